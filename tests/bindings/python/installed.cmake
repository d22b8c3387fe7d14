# Installs the package with pip, offline, into a folder of its own, and uses it there.
#   cmake -D PYTHON=.. -D SOURCE=.. -D BUILD=.. -P installed.cmake
set(folder ${BUILD}/bindings/pip)
file(REMOVE_RECURSE ${folder})
execute_process(COMMAND ${PYTHON} -m pip install --quiet --no-index --no-deps --no-cache-dir --disable-pip-version-check
                        --root-user-action=ignore --target ${folder} --config-settings build=${BUILD} ${SOURCE}
                COMMAND_ERROR_IS_FATAL ANY)
# From elsewhere, and with the libraries of the build tree out of reach: its own must be found beside it.
execute_process(COMMAND ${CMAKE_COMMAND} -E env PYTHONPATH=${folder} ${PYTHON} -B -c
"import decid, pathlib
assert pathlib.Path(decid.__file__).parent == pathlib.Path('${folder}/decid')
loaded = [line.split()[-1] for line in open('/proc/self/maps') if 'libdecid.so' in line]
assert loaded and all(path.startswith('${folder}/decid/libdecid.so') for path in loaded), loaded
print(decid.identify(decid.simulate(seed=7)))" WORKING_DIRECTORY ${folder} OUTPUT_VARIABLE said COMMAND_ERROR_IS_FATAL ANY)
if(NOT said MATCHES "^usable\nKp ")
  message(FATAL_ERROR "the installed package said ${said}")
endif()
execute_process(COMMAND ${PYTHON} -m pip list --path ${folder} --format freeze --disable-pip-version-check OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
if(NOT listed MATCHES "decid==[0-9]")
  message(FATAL_ERROR "pip lists ${listed}")
endif()
