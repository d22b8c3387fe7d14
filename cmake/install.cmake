# What `cmake --install` puts where, and the package that other projects find with find_package(decid 0.2).
include(CMakePackageConfigHelpers)

get_property(libraries GLOBAL PROPERTY DECID_LIBRARIES)
install(TARGETS ${libraries} EXPORT decid-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY base sim $<$<BOOL:${DECID_DATASET}>:dataset> nn DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/decid
        FILES_MATCHING PATTERN "*.hpp"
        # The kernels themselves are compiled into the library, once an instruction set; only their table is for others.
        PATTERN "nn/kernels/vec_*" EXCLUDE PATTERN "nn/kernels/generic*" EXCLUDE PATTERN "nn/kernels/isa.hpp" EXCLUDE
        # What data sets are read and written with.
        PATTERN "csv.hpp" EXCLUDE PATTERN "npy.hpp" EXCLUDE PATTERN "json_object.hpp" EXCLUDE
        PATTERN "journal.hpp" EXCLUDE PATTERN "npz_parts.hpp" EXCLUDE PATTERN "zip.hpp" EXCLUDE
        PATTERN "table.hpp" EXCLUDE PATTERN "mat.hpp" EXCLUDE PATTERN "clock.hpp" EXCLUDE PATTERN "tilt_match.hpp" EXCLUDE
        PATTERN "columns.hpp" EXCLUDE PATTERN "measured_tilt.hpp" EXCLUDE PATTERN "stimulus_json.hpp" EXCLUDE
        # What the simulator is made of.
        PATTERN "checker.hpp" EXCLUDE PATTERN "controller.hpp" EXCLUDE PATTERN "lanes.hpp" EXCLUDE)
if(DECID_TOOLS)
  install(TARGETS decid RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/decid)
install(EXPORT decid-targets NAMESPACE decid:: DESTINATION ${package})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/decid-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/decid-config.cmake
                              INSTALL_DESTINATION ${package} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/decid-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/decid-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/decid-config-version.cmake
        DESTINATION ${package})

# The test's project uses all libraries, and runs on the machine that builds it.
if(DECID_TESTS AND DECID_DATASET AND NOT CMAKE_CROSSCOMPILING)
  add_test(NAME consumer
           COMMAND ${CMAKE_COMMAND} -D BUILD=${CMAKE_CURRENT_BINARY_DIR} -D CONFIG=$<CONFIG>
                   -D GENERATOR=${CMAKE_GENERATOR} -D COMPILER=${CMAKE_CXX_COMPILER}
                   -P ${PROJECT_SOURCE_DIR}/tests/consumer/check.cmake)
endif()
