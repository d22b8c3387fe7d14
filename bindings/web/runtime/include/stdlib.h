// Declares POSIX functions that libc++'s file system and decid use and wasi-libc lacks; posix.c defines them.
#pragma once

#include_next <stdlib.h>

#ifdef __cplusplus
extern "C" {
#endif
char* realpath(const char* path, char* resolved);
#ifdef __cplusplus
}
#endif
