# Installs a build tree below it, then configures, builds and runs the project beside this file against that.
#   cmake -D BUILD=DIR -D CONFIG=Release -D GENERATOR=.. -D COMPILER=.. -P check.cmake
set(scratch ${BUILD}/consumer)
file(REMOVE_RECURSE ${scratch})

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY OUTPUT_VARIABLE output)
  set(output "${output}" PARENT_SCOPE)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --config ${CONFIG} --prefix ${scratch}/prefix)
# The prefix moves: an installed package must not remember where it was.
file(RENAME ${scratch}/prefix ${scratch}/moved)
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${scratch}/build -G ${GENERATOR} -D CMAKE_BUILD_TYPE=${CONFIG}
    -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_PREFIX_PATH=${scratch}/moved)
run(${CMAKE_COMMAND} --build ${scratch}/build --config ${CONFIG})
run(${scratch}/build/consumer)
message(STATUS "${output}")
if(EXISTS ${BUILD}/tools/decid)
  run(${scratch}/moved/bin/decid --version)
endif()
