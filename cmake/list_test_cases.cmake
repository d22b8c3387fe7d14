# Asks a doctest program for its cases and writes a CTest entry for each (decid_test in DecidTests.cmake).
#   cmake -D PROGRAM=.. -D EMULATOR=.. -D LIMIT_S=.. -D SLOW_LIMIT_S=.. -D LONG_LIMIT_S=.. -D CASES=OUTPUT -P list_test_cases.cmake
execute_process(COMMAND ${EMULATOR} ${PROGRAM} --list-test-cases --reporters=xml OUTPUT_VARIABLE xml
                RESULT_VARIABLE result ERROR_VARIABLE error)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} does not list its cases: ${result}\n${error}")
endif()

# Brackets and semicolons mean something in CMake's lists.
string(REPLACE ";" "&semicolon" xml "${xml}")
string(REPLACE "[" "&open" xml "${xml}")
string(REPLACE "]" "&close" xml "${xml}")
string(REGEX MATCHALL "<TestCase [^\n]*" cases "${xml}")
set(script "")
list(JOIN EMULATOR " " emulator)
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
  set(entry "[==[${stem}: ${name}]==]")
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
  string(APPEND script "add_test(${entry} ${emulator} [==[${PROGRAM}]==] [==[--test-case=${filter}]==] "
                       "[==[--source-file=*tests/${file}]==] --case-sensitive)\n"
                       "set_tests_properties(${entry} PROPERTIES ${properties} ENVIRONMENT OMP_WAIT_POLICY=passive "
                       "FAIL_REGULAR_EXPRESSION \"test cases: +0 \")\n")
endforeach()
file(WRITE ${CASES} "${script}")
