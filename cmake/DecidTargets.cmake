# How every target of the project is compiled, in one place.

# Settings that all code shares. -ffp-contract=off: a fused multiply-add happens where the source says fma(), nowhere
# else; g++ fuses by default, and the bits of a build would depend on the instruction set it was made for.
# -fno-tree-vectorize: given an instruction set with FMA, g++ 12's vectorizer turns neighbouring x * y - z and x * y + z
# into vfmaddsub in spite of it; what has to be fast is vectorised by hand.
# -Wno-restrict: g++ 12 warns wrongly of "text" + std::string (GCC bug 105651).
function(decid_compile_options target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE -ffp-contract=off -fno-math-errno -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                                           $<$<CXX_COMPILER_ID:GNU>:-fno-tree-vectorize;-Wno-restrict>
                                           $<$<BOOL:${DECID_WARNINGS_AS_ERRORS}>:-Werror>)
  if(DECID_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${DECID_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
    target_link_options(${target} PUBLIC -fsanitize=${DECID_SANITIZE})
  endif()
endfunction()

# decid_library(name sources...): static library decid_<name>, alias decid::<name>; includes are written from the root
# of the project ("sim/fft.hpp"), installed below include/decid.
function(decid_library name)
  add_library(decid_${name} STATIC ${ARGN})
  add_library(decid::${name} ALIAS decid_${name})
  set_target_properties(decid_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(decid_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                  $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/decid>)
  decid_compile_options(decid_${name})
  set_property(GLOBAL APPEND PROPERTY DECID_LIBRARIES decid_${name})
endfunction()

# decid_test(name sources...): doctest program test_<name>, one CTest entry. What implements doctest is compiled once.
# DECID_SANITIZED is defined where sanitizers are on, for what they cannot run or make too slow to be worth it.
function(decid_test name)
  if(NOT TARGET decid_test_main)
    add_library(decid_test_main OBJECT ${PROJECT_SOURCE_DIR}/tests/main.cpp)
    decid_compile_options(decid_test_main)
    target_link_libraries(decid_test_main PUBLIC doctest::doctest)
  endif()
  add_executable(test_${name} ${ARGN})
  decid_compile_options(test_${name})
  target_link_libraries(test_${name} PRIVATE decid_test_main)
  if(DECID_SANITIZE)
    target_compile_definitions(test_${name} PRIVATE DECID_SANITIZED)
  endif()
  add_test(NAME ${name} COMMAND test_${name})
  # Small steps by the thousand: threads that spin while they wait cost minutes on a busy machine.
  set_tests_properties(${name} PROPERTIES ENVIRONMENT "OMP_WAIT_POLICY=passive")
endfunction()

# decid_kernels(library): adds kernels/kernels_<instruction set>.cpp of the current folder to decid_<library>, one
# translation unit an instruction set; only these are compiled for more than the baseline. -O3 in every build type: they
# define nothing but internal functions and one table, so no build of them can leak into other code, and what a kernel
# keeps in registers stays there in debug builds too.
function(decid_kernels library)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
    set(flags_baseline "")
    set(flags_avx2 -mavx2 -mfma)
    # g++ 12 takes the undefined register that its own AVX-512 intrinsics start from for a mistake (GCC bug 105593).
    set(flags_avx512 -mavx2 -mfma -mavx512f $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
    set(isas baseline avx2 avx512)
  elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")
    set(flags_neon "")
    set(isas neon)
  else()
    message(FATAL_ERROR "No kernels for ${CMAKE_SYSTEM_PROCESSOR}: decid runs on x86-64 and AArch64")
  endif()
  foreach(isa ${isas})
    target_sources(decid_${library} PRIVATE kernels/kernels_${isa}.cpp)
    set_source_files_properties(kernels/kernels_${isa}.cpp PROPERTIES COMPILE_OPTIONS "-O3;${flags_${isa}}")
  endforeach()
endfunction()
