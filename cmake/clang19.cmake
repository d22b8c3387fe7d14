# The newest clang of Debian 12, with its own OpenMP runtime, which tools/setup --check fetches to build/clang19-packages:
# Debian installs one version of it only, and that is clang 14's.
set(CMAKE_C_COMPILER clang-19)
set(CMAKE_CXX_COMPILER clang++-19)
get_filename_component(llvm ${CMAKE_CURRENT_LIST_DIR}/../build/clang19-packages/usr/lib/llvm-19 ABSOLUTE)
# libstdc++ 12 sorts with a function of its own that it has marked as deprecated.
set(CMAKE_CXX_FLAGS_INIT "-isystem ${llvm}/lib/clang/19/include -Wno-deprecated-declarations")
foreach(kind EXE SHARED)
  set(CMAKE_${kind}_LINKER_FLAGS_INIT "-L${llvm}/lib -Wl,-rpath,${llvm}/lib")
endforeach()
