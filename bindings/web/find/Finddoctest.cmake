# doctest, with exceptions (doctest/doctest/doctest.h).
add_library(doctest::doctest INTERFACE IMPORTED GLOBAL)
set_target_properties(doctest::doctest PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${CMAKE_CURRENT_LIST_DIR}/doctest;${packages}/include"
                                                 INTERFACE_COMPILE_DEFINITIONS "DOCTEST_CONFIG_NO_POSIX_SIGNALS;DOCTEST_CONFIG_NO_MULTITHREADING")
set(doctest_FOUND TRUE)
