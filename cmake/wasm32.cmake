# WebAssembly with WASI, for bindings/web: clang 19, Debian's C library for it (wasi-libc) and the headers of its C++ library, which
# tools/setup --check unpacks in build/web-packages; the C++ library itself is compiled with exceptions (bindings/web/runtime).
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR wasm32)
set(CMAKE_C_COMPILER clang-19)
set(CMAKE_CXX_COMPILER clang++-19)
set(CMAKE_C_COMPILER_TARGET wasm32-wasi)
set(CMAKE_CXX_COMPILER_TARGET wasm32-wasi)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
get_filename_component(root ${CMAKE_CURRENT_LIST_DIR}/.. ABSOLUTE)
set(packages ${root}/build/web-packages/usr)
set(wasi "-D_WASI_EMULATED_SIGNAL -D_WASI_EMULATED_GETPID -D_WASI_EMULATED_PROCESS_CLOCKS -isystem ${packages}/include/wasm32-wasi")
set(CMAKE_C_FLAGS_INIT "-msimd128 -mbulk-memory -mnontrapping-fptoint -isystem ${root}/bindings/web/runtime/include ${wasi}")
set(CMAKE_CXX_FLAGS_INIT "-fwasm-exceptions -msimd128 -mbulk-memory -mnontrapping-fptoint -nostdinc++ -isystem ${root}/bindings/web/runtime/include -isystem ${packages}/lib/llvm-19/include/wasm32-wasi/c++/v1 ${wasi}")
# -O0: given another, clang hands the program to a wasm-opt that it finds, which may be too old to know what is in it.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-fuse-ld=${packages}/bin/wasm-ld-19 -nodefaultlibs -nostartfiles -L${packages}/lib/wasm32-wasi ${packages}/lib/wasm32-wasi/crt1-command.o -Wl,-z,stack-size=4194304 -Wl,--stack-first -O0 -Wl,-O2,--strip-all,--compress-relocations")
set(DECID_WASI_LIBRARIES wasi-emulated-signal wasi-emulated-getpid wasi-emulated-process-clocks c-printscan-long-double c m
    ${packages}/lib/llvm-19/lib/clang/19/lib/wasi/libclang_rt.builtins-wasm32.a)
set(CMAKE_CROSSCOMPILING_EMULATOR ${root}/bindings/web/run)
set(CMAKE_FIND_ROOT_PATH ${packages} ${packages}/..)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
# Packages that Debian has compiled for others, and what stands for them.
list(APPEND CMAKE_MODULE_PATH ${root}/bindings/web/find)
