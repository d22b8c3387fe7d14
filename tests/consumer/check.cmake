# Installs a build tree below it, then configures, builds and runs the project beside this file against that.
#   cmake -D BUILD=DIR -D CONFIG=Release -D GENERATOR=.. -D COMPILER=.. [-D TOOLCHAIN=FILE] [-D HEADERS_ALONE=ON] -P check.cmake
# HEADERS_ALONE: compiles each installed header on its own, and nothing else.
set(scratch ${BUILD}/consumer)
if(HEADERS_ALONE)
  set(scratch ${BUILD}/consumer_headers)
endif()
file(REMOVE_RECURSE ${scratch})

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY OUTPUT_VARIABLE output)
  set(output "${output}" PARENT_SCOPE)
endfunction()

# The consumer's own code need not be fast.
string(TOUPPER ${CONFIG} upper)
set(configure ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -G ${GENERATOR} -D CMAKE_BUILD_TYPE=${CONFIG} -D CMAKE_CXX_FLAGS_${upper}=-O0
    -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_PREFIX_PATH=${scratch}/moved)
if(TOOLCHAIN)
  list(APPEND configure -D CMAKE_TOOLCHAIN_FILE=${TOOLCHAIN})
endif()

# refuse(part settings...): configuring fails, with `part` in its message.
function(refuse part)
  execute_process(COMMAND ${configure} -B ${scratch}/refused --fresh ${ARGN} RESULT_VARIABLE result
                  OUTPUT_QUIET ERROR_VARIABLE said)
  string(REGEX REPLACE "[ \n]+" " " said "${said}")
  string(FIND "${said}" "${part}" place)
  if(result EQUAL 0 OR place EQUAL -1)
    message(FATAL_ERROR "expected '${part}' from configuring with ${ARGN}, which said ${said}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --config ${CONFIG} --prefix ${scratch}/prefix)
# The prefix moves: an installed package must not remember where it was.
file(RENAME ${scratch}/prefix ${scratch}/moved)

if(HEADERS_ALONE)
  run(${configure} -B ${scratch}/build -D HEADERS_ALONE=ON)
  run(${CMAKE_COMMAND} --build ${scratch}/build --config ${CONFIG} --parallel 2 --target headers)
  return()
endif()

# All components.
run(${configure} -B ${scratch}/build)
run(${CMAKE_COMMAND} --build ${scratch}/build --config ${CONFIG} --parallel 2)
foreach(program engine identification inference training)
  run(${scratch}/build/${program})
  message(STATUS "${output}")
endforeach()
if(EXISTS ${BUILD}/tools/decid)
  run(${scratch}/moved/bin/decid --version)
  run(${scratch}/moved/bin/decid info ${scratch}/moved/share/decid/models/dec2015.safetensors)
endif()

# Two of them, without what only others need.
set(without -D CMAKE_DISABLE_FIND_PACKAGE_ZLIB=ON -D CMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON
            -D CMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON)
run(${configure} -B ${scratch}/parts -D WANTED=image,nn ${without})
run(${CMAKE_COMMAND} --build ${scratch}/parts --config ${CONFIG})
run(${scratch}/parts/inference)
if(EXISTS ${scratch}/moved/lib/libdecid_npz.a)
  refuse("ZLIB" -D WANTED=image,nn,npz ${without})
endif()
refuse("it has no component 'imgae'; the components installed here are base, sim, posterior, nn" -D WANTED=imgae,nn)

# The engine alone, with a layer of the consumer's own.
run(${configure} -B ${scratch}/engine -D WANTED=nn ${without})
run(${CMAKE_COMMAND} --build ${scratch}/engine --config ${CONFIG})
run(${scratch}/engine/engine)
message(STATUS "${output}")

# Without CMake, by pkg-config's flags. Programs that use sanitized libraries would need the sanitizers' flags, too.
file(STRINGS ${BUILD}/CMakeCache.txt instrumented REGEX "^(DECID_SANITIZE:.*=.+|DECID_COVERAGE:.*=ON)$")
if(NOT instrumented)
  find_program(PKG_CONFIG pkg-config REQUIRED)
  file(GLOB_RECURSE description ${scratch}/moved/decid-nn.pc)
  cmake_path(GET description PARENT_PATH folder)
  cmake_path(GET folder PARENT_PATH libraries)
  set(ENV{PKG_CONFIG_PATH} ${folder})
  file(GLOB components RELATIVE ${folder} ${folder}/decid-*.pc)
  list(TRANSFORM components REPLACE "\\.pc$" "")
  run(${PKG_CONFIG} --exists --print-errors ${components})  # and what they require
  run(${PKG_CONFIG} --cflags --libs decid-nn)
  separate_arguments(flags UNIX_COMMAND "${output}")
  run(${COMPILER} -std=c++20 ${CMAKE_CURRENT_LIST_DIR}/engine.cpp -o ${scratch}/engine/engine_without_cmake ${flags}
      -Wl,-rpath,${libraries})
  run(${scratch}/engine/engine_without_cmake)
endif()

# No header that is private is there.
foreach(header base/files/json_object.hpp sim/protocol/detail/stimulus_json.hpp dataset/npz/detail/zip.hpp nn/kernels/generic.hpp)
  if(EXISTS ${scratch}/moved/include/decid/${header})
    message(FATAL_ERROR "${header} is installed")
  endif()
endforeach()
