# zlib from Debian's source (bindings/web/runtime).
if(NOT TARGET ZLIB::ZLIB)
  add_library(ZLIB::ZLIB ALIAS decid_web_zlib)
endif()
set(ZLIB_FOUND TRUE)
set(ZLIB_VERSION 1.2.13)
