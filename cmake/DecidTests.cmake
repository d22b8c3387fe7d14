# How tests are entered in CTest: each case of doctest (but see decid_test) and each script is an entry of its own, has a
# label, the folder below tests/ that it stands in, and a time limit. `ctest -L sim` runs a folder, `-LE "slow|long"` what
# takes less than 5 s.

# Seconds after which a test has failed: a machine may be busy, but not that busy.
set(DECID_TEST_LIMIT_S 120)
set(DECID_SLOW_TEST_LIMIT_S 900)
set(DECID_LONG_TEST_LIMIT_S 7200)
if(DECID_SANITIZE OR DECID_COVERAGE OR CMAKE_CROSSCOMPILING)
  set(factor 4)
  if(CMAKE_CROSSCOMPILING)  # an emulator takes some forty times as long
    set(factor 16)
  endif()
  math(EXPR DECID_TEST_LIMIT_S "${factor} * ${DECID_TEST_LIMIT_S}")
  math(EXPR DECID_SLOW_TEST_LIMIT_S "2 * ${DECID_SLOW_TEST_LIMIT_S}")
endif()

# decid_test_headers(target): precompiles the headers of nearly every test, where CMAKE_UNITY_BUILD asks for speed. Test
# sources stay apart, as helper names repeat among them. This halves clang's time. g++ 12 then reads 100 MB for each
# source, gains nothing and warns about system headers. The page's few tests define macros before they include doctest.
function(decid_test_headers target)
  if(NOT CMAKE_UNITY_BUILD OR NOT CMAKE_CXX_COMPILER_ID STREQUAL Clang OR CMAKE_SYSTEM_PROCESSOR STREQUAL wasm32)
    return()
  endif()
  if(NOT TARGET decid_test_headers)
    # An executable of no test, as headers are compiled for position-independent executables or for libraries.
    file(CONFIGURE OUTPUT no_test.cpp CONTENT "")
    add_executable(decid_test_headers ${CMAKE_CURRENT_BINARY_DIR}/no_test.cpp)
    decid_compile_options(decid_test_headers)
    decid_glue(decid_test_headers)
    decid_test_options(decid_test_headers)
    target_link_libraries(decid_test_headers PRIVATE decid::base decid_test_main)
    target_precompile_headers(decid_test_headers PRIVATE <doctest/doctest.h> <nlohmann/json.hpp> <algorithm> <cmath> <filesystem>
                              <fstream> <functional> <map> <memory> <numeric> <optional> <random> <span> <string> <vector>)
  endif()
  target_precompile_headers(${target} REUSE_FROM decid_test_headers)
endfunction()

function(decid_test_options target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD OFF)
  # After decid_glue's level: what takes time is in the libraries.
  if(NOT CMAKE_CROSSCOMPILING)  # an emulator's time is worth more than the compiler's
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O0>)
  endif()
  if(DECID_SANITIZE)
    # The tested code is in the libraries; in the tests' own sources these checks take two fifths of the compile time.
    target_compile_options(${target} PRIVATE -fno-sanitize=undefined)
  endif()
endfunction()

# decid_test_batches(result name sources...): sets `result` to the sources that test_<name> compiles. Where CMAKE_UNITY_BUILD
# asks for speed, one source includes up to 24 test files (batch_tests.cmake). A file that includes C code or replaces
# operator new must stay outside a namespace, and is compiled separately.
function(decid_test_batches result name)
  if(NOT CMAKE_UNITY_BUILD)
    set(${result} ${ARGN} PARENT_SCOPE)
    return()
  endif()
  set(compiled "")
  set(files "")
  foreach(source IN LISTS ARGN)
    get_filename_component(source ${source} ABSOLUTE)
    file(STRINGS ${source} global REGEX "^#include .*\\.c\"|operator (new|delete)\\(")
    if(global)
      list(APPEND compiled ${source})
    else()
      list(APPEND files ${source})
    endif()
  endforeach()
  # As many to each batch.
  list(LENGTH files count)
  math(EXPR batches "(${count} + 23) / 24")
  set(part "")
  set(batch 0)
  set(begun 0)
  foreach(source IN LISTS files)
    list(APPEND part ${source})
    math(EXPR begun "${begun} + 1")
    math(EXPR full "(${batch} + 1) * ${count} / ${batches}")
    if(begun LESS full)
      continue()
    endif()
    list(JOIN part "," sources)
    set(output ${CMAKE_CURRENT_BINARY_DIR}/test_${name}_${batch}.cpp)
    add_custom_command(OUTPUT ${output} DEPENDS ${part} ${PROJECT_SOURCE_DIR}/cmake/batch_tests.cmake VERBATIM
      COMMAND ${CMAKE_COMMAND} -D ROOT=${PROJECT_SOURCE_DIR} -D SOURCES=${sources} -D OUTPUT=${output}
              -P ${PROJECT_SOURCE_DIR}/cmake/batch_tests.cmake)
    list(APPEND compiled ${output})
    set(part "")
    math(EXPR batch "${batch} + 1")
  endforeach()
  set(${result} ${compiled} PARENT_SCOPE)
endfunction()

# decid_test(name sources...): doctest program test_<name>, an entry "folder/file: case" for each of its cases, found
# when it has been built. With the address sanitizer, the cases of a file that have no suite are one entry. A suite is a
# second label, TEST_CASE(".." * doctest::test_suite("slow")): "slow" for a case that takes more than 5 s, "long" for one
# that only tools/check --long runs, "golden" for bits that every build must have.
function(decid_test name)
  if(NOT TARGET decid_test_main)
    add_library(decid_test_main OBJECT ${PROJECT_SOURCE_DIR}/tests/main.cpp)
    decid_compile_options(decid_test_main)
    decid_glue(decid_test_main)
    decid_test_options(decid_test_main)
    target_link_libraries(decid_test_main PUBLIC doctest::doctest)
  endif()
  decid_test_batches(sources ${name} ${ARGN})
  add_executable(test_${name} ${sources})
  decid_compile_options(test_${name})
  decid_glue(test_${name})
  decid_test_options(test_${name})
  decid_test_headers(test_${name})
  target_link_libraries(test_${name} PRIVATE decid_test_main)
  set(cases ${CMAKE_CURRENT_BINARY_DIR}/test_${name}_cases.cmake)
  set(slow_cases "")
  if(DECID_SANITIZE MATCHES "address")
    set(slow_cases ${PROJECT_SOURCE_DIR}/tests/slow_in_asan.txt)
  endif()
  add_custom_command(TARGET test_${name} POST_BUILD VERBATIM BYPRODUCTS ${cases}
    COMMAND ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:test_${name}> -D "EMULATOR=${CMAKE_CROSSCOMPILING_EMULATOR}"
            -D LIMIT_S=${DECID_TEST_LIMIT_S} -D SLOW_LIMIT_S=${DECID_SLOW_TEST_LIMIT_S}
            -D LONG_LIMIT_S=${DECID_LONG_TEST_LIMIT_S} -D "SLOW_CASES=${slow_cases}" -D CASES=${cases} -P ${PROJECT_SOURCE_DIR}/cmake/list_test_cases.cmake)
  set_property(TARGET test_${name} PROPERTY LINK_DEPENDS ${PROJECT_SOURCE_DIR}/cmake/list_test_cases.cmake ${slow_cases})
  # A program that has not been built is a test that fails.
  file(CONFIGURE OUTPUT ${cases}.in @ONLY CONTENT [[
if(EXISTS "@cases@")
  include("@cases@")
else()
  add_test(test_@name@_is_not_built test_@name@_is_not_built)
endif()
]])
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${cases}.in)
endfunction()

# decid_test_entry(folder/name [TOOLS variables..] [SLOW | LONG] [PROPERTIES ..] COMMAND ..): one entry for anything else. TOOLS names
# the variables of programs that it needs (decid_tool); without one of them the test fails and says how to get it.
function(decid_test_entry name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "SLOW;LONG" "" "TOOLS;PROPERTIES;COMMAND")
  foreach(tool IN LISTS arg_TOOLS)
    if(NOT ${tool})
      get_property(package GLOBAL PROPERTY ${tool}_PACKAGE)
      set(arg_COMMAND ${CMAKE_COMMAND} -D "PROBLEM=needs Debian's ${package}; install it with tools/setup --check and configure again"
                      -P ${PROJECT_SOURCE_DIR}/cmake/fail.cmake)
      set(arg_PROPERTIES "")
    endif()
  endforeach()
  add_test(NAME ${name} COMMAND ${arg_COMMAND})
  get_filename_component(labels ${name} DIRECTORY)
  set(limit_s ${DECID_TEST_LIMIT_S})
  # Scripts take longer than most cases and begin first, so that none of them ends alone.
  set(cost 10)
  if(arg_SLOW)
    list(APPEND labels slow)
    set(limit_s ${DECID_SLOW_TEST_LIMIT_S})
    set(cost 110)  # slow cases have 100
  elseif(arg_LONG)
    list(APPEND labels long)
    set(limit_s ${DECID_LONG_TEST_LIMIT_S})
  endif()
  set_tests_properties(${name} PROPERTIES LABELS "${labels}" TIMEOUT ${limit_s} COST ${cost} ENVIRONMENT OMP_WAIT_POLICY=passive
                                          ${arg_PROPERTIES})
endfunction()

# decid_tool(variable package names...): a program that tests need beside the compiler, and Debian's package of it.
function(decid_tool variable package)
  find_program(${variable} NAMES ${ARGN} DOC "Debian's ${package}")
  set_property(GLOBAL PROPERTY ${variable}_PACKAGE ${package})
endfunction()
