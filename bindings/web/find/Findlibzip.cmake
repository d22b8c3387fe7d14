# libzip's headers; what would call it has no place in a page, and the linker leaves it out.
add_library(libzip::zip INTERFACE IMPORTED GLOBAL)
set(libzip_FOUND TRUE)
set(libzip_VERSION 1.7.3)
