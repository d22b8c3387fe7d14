# The files that `cmake --install` copies, the package that other projects find with find_package(decid 0.2 COMPONENTS ..), and
# a pkg-config file decid-<name>.pc for each component.
include(CMakePackageConfigHelpers)

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/decid)
set(headers ${CMAKE_INSTALL_INCLUDEDIR}/decid)

# If some targets were never built (tools/demo builds the program only), the installation fails before its first file:
# otherwise it would end at the first missing one, with half a package in the prefix.
list(TRANSFORM components PREPEND decid_ OUTPUT_VARIABLE installed)
if(DECID_C)
  list(APPEND installed decid_c)
endif()
if(DECID_TOOLS)
  list(APPEND installed decid)
endif()
list(TRANSFORM installed REPLACE "(.+)" "$<TARGET_FILE:\\1>" OUTPUT_VARIABLE installed_files)
list(JOIN installed " " installed_names)
install(CODE "
foreach(file IN ITEMS ${installed_files})
  if(NOT EXISTS \"\${file}\")
    cmake_path(GET file FILENAME file)
    list(APPEND missing \${file})
  endif()
endforeach()
if(missing)
  list(JOIN missing \", \" missing)
  message(FATAL_ERROR \"Not built yet: \${missing}. Nothing is installed. \"
                      \"Build first: cmake --build '${PROJECT_BINARY_DIR}' --target ${installed_names}\")
endif()")

# An export a component, so that a component is found without what only others need.
set(DECID_PACKAGE_COMPONENTS ${components})
set(DECID_PACKAGE_STEPS "")
file(RELATIVE_PATH up /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" up ${up})
foreach(name IN LISTS components)
  get_target_property(more_headers decid_${name} INTERFACE_HEADER_SETS)
  list(REMOVE_ITEM more_headers HEADERS)
  list(TRANSFORM more_headers REPLACE "(.+)" "FILE_SET;\\1;DESTINATION;${headers}")
  install(TARGETS decid_${name} EXPORT decid-${name} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} FILE_SET HEADERS DESTINATION ${headers} ${more_headers})
  install(EXPORT decid-${name} NAMESPACE decid:: DESTINATION ${package})
  string(APPEND DECID_PACKAGE_STEPS "set(decid_needs_${name} ${DECID_NEEDS_${name}})\n")
  get_target_property(finds decid_${name} DECID_FINDS)
  get_target_property(type decid_${name} TYPE)
  # Headers use OpenMP; of the rest a shared library's user sees nothing.
  if(type STREQUAL "SHARED_LIBRARY")
    list(FILTER finds INCLUDE REGEX "^OpenMP ")
  endif()
  string(APPEND DECID_PACKAGE_STEPS "set(decid_finds_${name} \"${finds}\")\n")
  # OpenMP has no pkg-config file, but a flag of this compiler.
  list(TRANSFORM DECID_NEEDS_${name} PREPEND decid- OUTPUT_VARIABLE requires)
  set(flags "")
  foreach(find IN LISTS finds)
    if(find MATCHES "^OpenMP ")
      set(flags ${OpenMP_CXX_FLAGS})
    else()
      string(REPLACE " " " >= " find "${find}")
      string(TOLOWER "${find}" find)
      list(APPEND requires "${find}")
    endif()
  endforeach()
  list(JOIN requires ", " requires)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/component.pc.in ${CMAKE_CURRENT_BINARY_DIR}/decid-${name}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/decid-${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()
if(DECID_C)
  # The component c: it stands on nothing that has to be found.
  install(TARGETS decid_c EXPORT decid-c LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
          FILE_SET HEADERS DESTINATION ${headers})
  install(EXPORT decid-c NAMESPACE decid:: DESTINATION ${package})
  list(APPEND DECID_PACKAGE_COMPONENTS c)
  configure_file(${PROJECT_SOURCE_DIR}/bindings/c/decid.pc.in ${CMAKE_CURRENT_BINARY_DIR}/decid.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/decid.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endif()
if(DECID_TOOLS)
  install(TARGETS decid RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  # Models for --model; only the built-in one is in the program.
  file(GLOB models CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/models/*.safetensors)
  install(FILES ${models} DESTINATION ${CMAKE_INSTALL_DATADIR}/decid/models)
endif()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/decid-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/decid-config.cmake
                              INSTALL_DESTINATION ${package} NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/decid-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/decid-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/decid-config-version.cmake
        DESTINATION ${package})
