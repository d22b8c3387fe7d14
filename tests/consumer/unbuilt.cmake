# Installs from a build tree in which nothing was built yet, and from one in which a part was: nothing is written.
#   cmake -D SOURCE=DIR -D SCRATCH=DIR -D GENERATOR=.. -D COMPILER=.. [-D TOOLCHAIN=FILE] -P unbuilt.cmake
file(REMOVE_RECURSE ${SCRATCH})
set(configure ${CMAKE_COMMAND} -S ${SOURCE} -B ${SCRATCH}/build -G ${GENERATOR} -D CMAKE_BUILD_TYPE=Release
    -D CMAKE_CXX_COMPILER=${COMPILER} -D DECID_TESTS=OFF -D DECID_COMPONENTS=sim)
if(TOOLCHAIN)
  list(APPEND configure -D CMAKE_TOOLCHAIN_FILE=${TOOLCHAIN})
endif()
execute_process(COMMAND ${configure} COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)

# refuse(parts...): the installation fails, names each of the files, and leaves no prefix.
function(refuse)
  execute_process(COMMAND ${CMAKE_COMMAND} --install ${SCRATCH}/build --prefix ${SCRATCH}/prefix RESULT_VARIABLE result
                  OUTPUT_QUIET ERROR_VARIABLE said)
  if(result EQUAL 0 OR EXISTS ${SCRATCH}/prefix)
    message(FATAL_ERROR "the installation ended with ${result} and said ${said}")
  endif()
  foreach(part IN LISTS ARGN)
    string(FIND "${said}" "${part}" place)
    if(place EQUAL -1)
      message(FATAL_ERROR "expected '${part}' in ${said}")
    endif()
  endforeach()
endfunction()

refuse(libdecid_base libdecid_sim "cmake --build")
# As if the first of them had been built.
file(WRITE ${SCRATCH}/build/base/libdecid_base.a "")
refuse(libdecid_sim)
