// Declared for libc++'s file system; bindings/web/runtime/posix.c refuses it.
#pragma once

struct statvfs {
  unsigned long f_frsize, f_blocks, f_bfree, f_bavail;
};
#ifdef __cplusplus
extern "C"
#endif
    int
    statvfs(const char* path, struct statvfs* result);
