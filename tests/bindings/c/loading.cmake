# Checks the dynamic section: cmake -D READELF=... -D LIBRARY=libdecid.so -D PROGRAM=decid -D STATIC=1 -P loading.cmake
# With STATIC neither file needs shared libraries of the build tree; otherwise each lists their folders.
foreach(file ${LIBRARY} ${PROGRAM})
  execute_process(COMMAND ${READELF} -d ${file} OUTPUT_VARIABLE dynamic COMMAND_ERROR_IS_FATAL ANY)
  # An empty path is the current folder, whose libraries are anybody's.
  string(REGEX MATCH "PATH[^[]*\\[([^]]*)\\]" found "${dynamic}")
  if(STATIC AND found AND ":${CMAKE_MATCH_1}:" MATCHES "::")
    message(FATAL_ERROR "${file}: libraries are looked for in the current folder, by the paths [${CMAKE_MATCH_1}]")
  endif()
  if(file STREQUAL "${LIBRARY}" AND NOT dynamic MATCHES "NODELETE")
    message(FATAL_ERROR "${file}: dlclose() would leave threads of OpenMP without their code")
  endif()
endforeach()
