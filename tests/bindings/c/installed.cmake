# Installs a build tree, moves it, and builds examples/identify.c against it as users do: with pkg-config, and with CMake's
# find_package(decid COMPONENTS c), which must look for no other package.
#   cmake -D BUILD=.. -D CONFIG=.. -D SOURCE=.. -D C_COMPILER=.. -D PKG_CONFIG=.. -P installed.cmake
set(scratch ${BUILD}/bindings/installed)
file(REMOVE_RECURSE ${scratch})
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY OUTPUT_VARIABLE output OUTPUT_STRIP_TRAILING_WHITESPACE)
  set(output "${output}" PARENT_SCOPE)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --config ${CONFIG} --prefix ${scratch}/prefix)
file(RENAME ${scratch}/prefix ${scratch}/moved)
file(GLOB_RECURSE description ${scratch}/moved/decid.pc)
get_filename_component(folder ${description} DIRECTORY)
get_filename_component(libraries ${folder} DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${folder})
run(${PKG_CONFIG} --cflags --libs decid)
separate_arguments(flags UNIX_COMMAND "${output}")
run(${C_COMPILER} -std=c99 -Wall -Werror ${SOURCE}/examples/identify.c -o ${scratch}/identify ${flags} -Wl,-rpath,${libraries})

file(WRITE ${scratch}/project/CMakeLists.txt "cmake_minimum_required(VERSION 3.25)
project(user LANGUAGES C)
find_package(decid 0.2 REQUIRED COMPONENTS c)
add_executable(user ${SOURCE}/examples/identify.c)
target_link_libraries(user PRIVATE decid::c)
")
run(${CMAKE_COMMAND} -S ${scratch}/project -B ${scratch}/project/build -D CMAKE_PREFIX_PATH=${scratch}/moved
    -D CMAKE_C_COMPILER=${C_COMPILER} -D CMAKE_DISABLE_FIND_PACKAGE_OpenMP=ON -D CMAKE_DISABLE_FIND_PACKAGE_libzip=ON
    -D CMAKE_DISABLE_FIND_PACKAGE_ZLIB=ON)
run(${CMAKE_COMMAND} --build ${scratch}/project/build)

run(${BUILD}/tools/decid simulate --seed 7 --quiet -o ${scratch}/trial.csv)
foreach(program identify project/build/user)
  run(${scratch}/${program} ${scratch}/trial.csv)
  if(NOT output MATCHES "delay")
    message(FATAL_ERROR "${program} said ${output}")
  endif()
endforeach()
