# One translation unit an instruction set; only these are compiled for more than the baseline. -O3 in every build type:
# they define nothing but internal functions and one table, so no build of them can leak into other code, and the
# accumulators of a tile stay in registers in debug builds too.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
  target_sources(decid_nn PRIVATE kernels/kernels_baseline.cpp kernels/kernels_avx2.cpp kernels/kernels_avx512.cpp)
  set_source_files_properties(kernels/kernels_baseline.cpp PROPERTIES COMPILE_OPTIONS "-O3")
  set_source_files_properties(kernels/kernels_avx2.cpp PROPERTIES COMPILE_OPTIONS "-O3;-mavx2;-mfma")
  set_source_files_properties(kernels/kernels_avx512.cpp PROPERTIES COMPILE_OPTIONS "-O3;-mavx2;-mfma;-mavx512f")
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")
  target_sources(decid_nn PRIVATE kernels/kernels_neon.cpp)
  set_source_files_properties(kernels/kernels_neon.cpp PROPERTIES COMPILE_OPTIONS "-O3")
endif()
