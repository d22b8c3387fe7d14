# A page has one thread (bindings/web/runtime): the pragmas are comments.
add_library(OpenMP::OpenMP_CXX INTERFACE IMPORTED GLOBAL)
set(OpenMP_FOUND TRUE)
set(OpenMP_CXX_FOUND TRUE)
