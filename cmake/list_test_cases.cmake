# Asks a doctest program for its cases and writes a CTest entry for each (decid_test in DecidTests.cmake).
#   cmake -D PROGRAM=.. -D EMULATOR=.. -D LIMIT_S=.. -D SLOW_LIMIT_S=.. -D LONG_LIMIT_S=.. [-D SLOW_CASES=FILE] -D CASES=OUTPUT
#         -P list_test_cases.cmake
# SLOW_CASES: lines "folder/file: case | reason" of cases that are slow in this build. One of this program's files that names no
# case of it is an error. In such a build, whose programs start slowly, the cases of a file without a suite are one entry.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND ${EMULATOR} ${PROGRAM} --list-test-cases --reporters=xml OUTPUT_VARIABLE xml
                RESULT_VARIABLE result ERROR_VARIABLE error)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} does not list its cases: ${result}\n${error}")
endif()

set(slow_cases "")
set(found_slow "")
if(SLOW_CASES)
  file(STRINGS ${SLOW_CASES} lines REGEX "^[^#]")
  foreach(line IN LISTS lines)
    string(REGEX REPLACE " +\\|.*$" "" line "${line}")
    string(REPLACE ";" "&semicolon" line "${line}")
    list(APPEND slow_cases "${line}")
  endforeach()
endif()

# Brackets and semicolons mean something in CMake's lists.
string(REPLACE ";" "&semicolon" xml "${xml}")
string(REPLACE "[" "&open" xml "${xml}")
string(REPLACE "]" "&close" xml "${xml}")
string(REGEX MATCHALL "<TestCase [^\n]*" cases "${xml}")
set(script "")
list(JOIN EMULATOR " " emulator)

# enter(name file filters properties): writes an entry that runs the file's cases that pass doctest's filters.
function(enter name file filters properties)
  string(APPEND script "add_test([==[${name}]==] ${emulator} [==[${PROGRAM}]==] ${filters} "
                       "[==[--source-file=*tests/${file}]==] --case-sensitive)\n"
                       "set_tests_properties([==[${name}]==] PROPERTIES ${properties} ENVIRONMENT OMP_WAIT_POLICY=passive "
                       "FAIL_REGULAR_EXPRESSION \"test cases: +0 \")\n")
  set(script "${script}" PARENT_SCOPE)
endfunction()

set(files_together "")
foreach(case IN LISTS cases)
  if(NOT case MATCHES "name=\"([^\"]*)\"( testsuite=\"([^\"]*)\")? filename=\"([^\"]*)\"")
    message(FATAL_ERROR "${PROGRAM} lists what is no case: ${case}")
  endif()
  set(name "${CMAKE_MATCH_1}")
  set(suite "${CMAKE_MATCH_3}")
  # A compiler cache may have made the name relative to somewhere.
  string(REGEX REPLACE "^.*tests/" "" file "${CMAKE_MATCH_4}")
  foreach(pair "&open=[" "&close=]" "&quot&semicolon=\"" "&lt&semicolon=<" "&gt&semicolon=>" "&amp&semicolon=&")
    string(REGEX MATCH "^([^=]*)=(.*)$" pair "${pair}")
    string(REPLACE "${CMAKE_MATCH_1}" "${CMAKE_MATCH_2}" name "${name}")
  endforeach()
  string(REPLACE "&semicolon" ";" name "${name}")
  string(REPLACE "," "\\," filter "${name}")
  get_filename_component(folder ${file} DIRECTORY)
  string(REGEX REPLACE "\\.cpp$" "" stem ${file})
  list(APPEND stems ${stem})
  string(REPLACE ";" "&semicolon" listed "${stem}: ${name}")
  if(listed IN_LIST slow_cases)
    list(APPEND found_slow "${listed}")
    set(suite slow)
    string(APPEND apart_of_${file} ",${filter}")
  endif()
  if(SLOW_CASES AND suite STREQUAL "" AND NOT case MATCHES "skipped=\"true\"")
    list(APPEND files_together ${file})
    list(APPEND together_of_${file} ${name})
    continue()
  endif()
  set(properties "LABELS \"${folder};${suite}\" TIMEOUT ${LIMIT_S}")
  if(suite STREQUAL "slow")
    # Cost: these begin first, so that none of them ends alone.
    set(properties "LABELS \"${folder};slow\" TIMEOUT ${SLOW_LIMIT_S} COST 100")
  elseif(suite STREQUAL "long")
    set(properties "LABELS \"${folder};long\" TIMEOUT ${LONG_LIMIT_S} COST 200")
  elseif(suite AND NOT suite STREQUAL "golden")
    message(FATAL_ERROR "${file}: the case '${name}' is in the suite '${suite}'; there are slow, long and golden")
  endif()
  if(case MATCHES "skipped=\"true\"")
    string(APPEND properties " DISABLED TRUE")
  endif()
  enter("${stem}: ${name}" ${file} "[==[--test-case=${filter}]==]" "${properties}")
endforeach()
list(REMOVE_DUPLICATES files_together)
foreach(file IN LISTS files_together)
  get_filename_component(folder ${file} DIRECTORY)
  string(REGEX REPLACE "\\.cpp$" "" stem ${file})
  list(LENGTH together_of_${file} count)  # as a cost: files of many cases begin first
  enter("${stem}: fast cases" ${file} "--test-suite-exclude=slow,long,golden [==[--test-case-exclude=${apart_of_${file}}]==]"
        "LABELS \"${folder}\" TIMEOUT ${LIMIT_S} COST ${count}")
endforeach()
foreach(case IN LISTS slow_cases)
  string(REGEX REPLACE ": .*$" "" stem "${case}")
  if(stem IN_LIST stems AND NOT case IN_LIST found_slow)
    message(FATAL_ERROR "${SLOW_CASES} names '${case}', which ${PROGRAM} has not")
  endif()
endforeach()
file(WRITE ${CASES} "${script}")
