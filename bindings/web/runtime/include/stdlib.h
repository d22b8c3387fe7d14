// What wasi-libc's headers leave out of POSIX and libc++'s file system and decid name; bindings/web/runtime/posix.c has it.
#pragma once

#include_next <stdlib.h>

#ifdef __cplusplus
extern "C" {
#endif
char* realpath(const char* path, char* resolved);
#ifdef __cplusplus
}
#endif
