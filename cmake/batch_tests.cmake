# Writes one source that includes several test files, so that the compiler reads their headers once (decid_test_batches in
# DecidTests.cmake). Test files reuse each other's helper names, so the source includes each file in a namespace of its
# own. The headers of all files come first, outside these namespaces. Where a file opens `namespace decid`, a using
# directive makes the library's names visible there.
#   cmake -D ROOT=PROJECT -D SOURCES=FILE,FILE -D OUTPUT=FILE -P batch_tests.cmake
string(REPLACE "," ";" sources "${SOURCES}")
set(headers "")
set(bodies "")
foreach(source IN LISTS sources)
  file(STRINGS ${source} lines REGEX "^#include [<\"]")
  foreach(line IN LISTS lines)
    string(REGEX REPLACE "[ \t]*//.*$" "" line "${line}")
    if(line MATCHES "^#include" AND NOT line MATCHES "\\.(inc|c)\"$")
      list(APPEND headers "${line}")
    endif()
  endforeach()
  file(RELATIVE_PATH name ${ROOT} ${source})
  string(MAKE_C_IDENTIFIER ${name} name)
  set(directives "")
  file(STRINGS ${source} opened REGEX "^namespace decid[a-z_:]* {")
  list(REMOVE_DUPLICATES opened)
  foreach(line IN LISTS opened)
    string(REGEX MATCH "decid[a-z_:]*" space "${line}")
    # The file's decid::tools hides ::decid::tools, so each level needs a directive; no header may have opened it yet.
    string(APPEND bodies "\nnamespace ${space} {}\n")
    set(path "")
    string(REPLACE "::" ";" levels "${space}")
    foreach(level IN LISTS levels)
      string(APPEND path "::${level}")
      string(SUBSTRING "${path}" 2 -1 inner)
      string(APPEND directives "namespace ${inner} {\nusing namespace ${path};\n}\n")
    endforeach()
  endforeach()
  string(APPEND bodies "\nnamespace ${name} {\n${directives}#include \"${source}\"\n}\n")
endforeach()
list(REMOVE_DUPLICATES headers)
list(SORT headers)  # "project" headers sort before <system> ones
list(JOIN headers "\n" headers)
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "${headers}\n${bodies}" @ONLY)
