# How every target of the project is compiled, in one place.

# Settings that all code shares. -ffp-contract=off: a fused multiply-add happens where the source says fma(), nowhere
# else; g++ fuses by default, and the bits of a build would depend on the instruction set it was made for.
# -fno-tree-vectorize: given an instruction set with FMA, g++ 12's vectorizer turns neighbouring x * y - z and x * y + z
# into vfmaddsub in spite of it; what has to be fast is vectorised by hand.
# -Wno-restrict: g++ 12 warns wrongly of "text" + std::string (GCC bug 105651).
# ggc-*: g++ collects its garbage from 1 GB on instead of 128 MB, which saves an eighth of its time and changes no code.
function(decid_compile_options target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE -ffp-contract=off -fno-math-errno -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                                           $<$<CXX_COMPILER_ID:GNU>:-fno-tree-vectorize;-Wno-restrict;--param=ggc-min-expand=1000;--param=ggc-min-heapsize=1000000>
                                           $<$<BOOL:${DECID_WARNINGS_AS_ERRORS}>:-Werror>)
  # Sanitizers see more, and WebAssembly has its own guards.
  if(DECID_HARDEN AND NOT DECID_SANITIZE AND NOT CMAKE_SYSTEM_PROCESSOR STREQUAL "wasm32")
    # _FORTIFY_SOURCE needs an optimiser.
    target_compile_options(${target} PRIVATE -fstack-protector-strong -D_GLIBCXX_ASSERTIONS
                                             $<$<CONFIG:Release>:-U_FORTIFY_SOURCE;-D_FORTIFY_SOURCE=2>)
    if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
      target_compile_options(${target} PRIVATE -fcf-protection)
    endif()
    get_target_property(type ${target} TYPE)
    target_link_options(${target} PRIVATE -Wl,-z,relro,-z,now)
    if(type STREQUAL "EXECUTABLE")
      target_link_options(${target} PRIVATE -pie)
    endif()
  endif()
  if(DECID_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${DECID_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
    # For what they cannot run or make too slow to be worth it.
    target_compile_definitions(${target} PRIVATE DECID_SANITIZED)
    target_link_options(${target} PUBLIC -fsanitize=${DECID_SANITIZE})
  endif()
  if(DECID_COVERAGE)
    # Threads count one after the other.
    target_compile_options(${target} PRIVATE --coverage -fprofile-update=atomic)
    target_compile_definitions(${target} PRIVATE DECID_COVERAGE)
    target_link_options(${target} PUBLIC --coverage)
  endif()
endfunction()

# decid_no_empty_rpath(target): one that is linked with no shared library of the build tree has its installed paths there too.
# Otherwise CMake makes room for them with empty ones, and the loader takes each for the current folder.
function(decid_no_empty_rpath target)
  if(NOT BUILD_SHARED_LIBS)
    set_target_properties(${target} PROPERTIES BUILD_WITH_INSTALL_RPATH ON)
  endif()
endfunction()

# decid_component(name folder needs...): a dependency layer; the layers that it needs have been named before it.
macro(decid_component name folder)
  list(APPEND DECID_LAYERS ${name})
  set(DECID_FOLDER_${name} ${folder})
  set(DECID_NEEDS_${name} ${ARGN})
endmacro()

# decid_wanted_components(result): those of DECID_COMPONENTS with all that they need, in the order of the layers.
function(decid_wanted_components result)
  if(DECID_COMPONENTS STREQUAL "all")
    set(wanted ${DECID_LAYERS})
  else()
    set(wanted ${DECID_COMPONENTS})
  endif()
  set(components "")
  foreach(name IN LISTS wanted)
    if(NOT name IN_LIST DECID_LAYERS)
      message(FATAL_ERROR "DECID_COMPONENTS names '${name}'; there are ${DECID_LAYERS}")
    endif()
  endforeach()
  set(upside_down ${DECID_LAYERS})
  list(REVERSE upside_down)
  foreach(name IN LISTS upside_down)
    if(name IN_LIST wanted)
      list(PREPEND components ${name})
      list(APPEND wanted ${DECID_NEEDS_${name}})
    endif()
  endforeach()
  set(${result} ${components} PARENT_SCOPE)
endfunction()

# decid_lean_coverage(target): leaves only the fuzzer's counters in a build with sanitizers, whose tests run the same code. Calls
# for each comparison took a tenth of their time and gave its targets no more coverage; tables of addresses make every start longer.
function(decid_lean_coverage target)
  if(DECID_SANITIZE)
    target_compile_options(${target} PRIVATE -fno-sanitize-coverage=trace-cmp,pc-table)
  endif()
endfunction()

# decid_library(name SOURCES .. HEADERS .. [FINDS ..]): library decid_<name>, alias decid::<name>, of the component
# <name>, linked with what it stands on. HEADERS are those that others may include: they are installed, and a header
# that is not among them is not. Includes are written from the root of the project ("sim/fft.hpp"); where decid is
# installed, <decid/sim/fft.hpp> is the same file. FINDS: packages with versions that whoever links the installed
# library has to find too ("ZLIB 1.2.11"); of a shared library nobody has to.
function(decid_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;HEADERS;FINDS")
  add_library(decid_${name} ${arg_SOURCES})
  add_library(decid::${name} ALIAS decid_${name})
  # Below 1.0 every minor version may change the interface.
  set_target_properties(decid_${name} PROPERTIES EXPORT_NAME ${name} VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} INSTALL_RPATH $ORIGIN DEFINE_SYMBOL "")
  target_sources(decid_${name} PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${arg_HEADERS})
  target_include_directories(decid_${name} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  list(TRANSFORM DECID_NEEDS_${name} PREPEND decid:: OUTPUT_VARIABLE needs)
  target_link_libraries(decid_${name} PUBLIC ${needs})
  decid_compile_options(decid_${name})
  if(DECID_FUZZ)
    target_compile_options(decid_${name} PRIVATE -fsanitize=fuzzer-no-link)
    decid_lean_coverage(decid_${name})
  endif()
  set_property(TARGET decid_${name} PROPERTY DECID_FINDS "${arg_FINDS}")
endfunction()

# decid_soname(result library): the name that the linker would write down for a shared library, for one that is not
# linked but loaded where it is needed (base/files/shared_library.hpp).
function(decid_soname result library)
  execute_process(COMMAND ${CMAKE_READELF} -d ${library} OUTPUT_VARIABLE dynamic COMMAND_ERROR_IS_FATAL ANY)
  if(NOT dynamic MATCHES "\\(SONAME\\)[^[]*\\[([^]]+)\\]")
    message(FATAL_ERROR "${library} is no shared library")
  endif()
  set(${result} ${CMAKE_MATCH_1} PARENT_SCOPE)
endfunction()

# decid_glue(target): code that reads options, writes pages and JSON or tests takes half as long to compile with -O1,
# where speed does not matter; with sanitizers, -O0; in a page it has to be small.
function(decid_glue target)
  if(DECID_SANITIZE)
    target_compile_options(${target} PRIVATE -O0)
  else()
    set(level -O1)
    if(CMAKE_SYSTEM_PROCESSOR STREQUAL wasm32)
      set(level -Oz)
    endif()
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:${level}>)
  endif()
endfunction()

# decid_computes(target): loops over samples and weights are worth -O3, in the presets' Release too, which is -O2. Their
# spans are not checked (DECID_HARDEN): that took 3 % of an inference's instructions, 5 % of a simulation's.
function(decid_computes target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O3;-U_GLIBCXX_ASSERTIONS>)
endfunction()

# decid_unoptimised_with_sanitizers(target): where few loops run long, -O0 halves the time of sanitizers' compilers.
function(decid_unoptimised_with_sanitizers target)
  if(DECID_SANITIZE)
    target_compile_options(${target} PRIVATE -O0)
  endif()
endfunction()

# decid_kernels(library): adds kernels/target.cpp of the current folder to decid_<library>, once for each instruction set
# with DECID_TARGET as its name; only these translation units are compiled for more than the baseline. They use -O3 in every
# build type: they define only internal functions and one table, so no copy can reach other code, and values of a kernel stay
# in registers in debug builds too. With sanitizers, whose checks dominate, -O3 takes too long.
function(decid_kernels library)
  set(level -O3)
  if(DECID_SANITIZE)
    set(level -O1)
  endif()
  if(DECID_FUZZ)
    # Arithmetic reads no file: its edges need no counting, which would slow its tests.
    list(APPEND level -fno-sanitize-coverage=inline-8bit-counters,indirect-calls,trace-cmp,pc-table)
  endif()
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
    set(flags_baseline "")
    set(flags_avx2 -mavx2 -mfma)
    # g++ 12 takes the undefined register that its own AVX-512 intrinsics start from for a mistake (GCC bug 105593).
    set(flags_avx512 -mavx2 -mfma -mavx512f $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
    set(isas baseline avx2 avx512)
    # The same templates as the baseline's, which has these checks; with them AVX-512's take clang 14 four times as long.
    if(DECID_SANITIZE)
      list(APPEND flags_avx2 -fno-sanitize=undefined)
      list(APPEND flags_avx512 -fno-sanitize=undefined)
    endif()
  elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")
    set(flags_neon "")
    set(isas neon)
  elseif(CMAKE_SYSTEM_PROCESSOR STREQUAL wasm32)
    set(flags_wasm "")
    set(flags_relaxed -mrelaxed-simd)
    set(isas wasm relaxed)
  else()
    message(FATAL_ERROR "No kernels for ${CMAKE_SYSTEM_PROCESSOR}: decid runs on x86-64, AArch64 and WebAssembly")
  endif()
  foreach(isa ${isas})
    set(source ${CMAKE_CURRENT_BINARY_DIR}/kernels_${isa}.cpp)
    file(CONFIGURE OUTPUT ${source} @ONLY CONTENT "#define DECID_TARGET @isa@\n#include \"@CMAKE_CURRENT_SOURCE_DIR@/kernels/target.cpp\"\n")
    target_sources(decid_${library} PRIVATE ${source})
    set_source_files_properties(${source} PROPERTIES COMPILE_OPTIONS "${level};${flags_${isa}}")
  endforeach()
endfunction()
