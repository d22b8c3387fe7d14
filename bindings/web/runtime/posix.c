// POSIX functions that decid and libc++'s file system call and wasi-libc lacks. Files of a page have neither
// permissions nor locks.
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>

int fchmod(int file, mode_t mode) {
  (void)file, (void)mode;
  return 0;
}

int fchmodat(int folder, const char* path, mode_t mode, int flags) {
  (void)folder, (void)path, (void)mode, (void)flags;
  return 0;
}

// A page has no symbolic links, and its paths are written as they are.
char* realpath(const char* path, char* resolved) {
  struct stat status;
  if (stat(path, &status) != 0) return NULL;
  return resolved != NULL ? strcpy(resolved, path) : strdup(path);
}

// The program has one thread, so its thread-local objects are destroyed at exit.
int __cxa_atexit(void (*destroy)(void*), void* object, void* library);
int __cxa_thread_atexit(void (*destroy)(void*), void* object, void* library) {
  return __cxa_atexit(destroy, object, library);
}

int statvfs(const char* path, struct statvfs* result) {
  (void)path, (void)result;
  errno = ENOSYS;
  return -1;
}

int flock(int file, int operation) {
  (void)file, (void)operation;
  return 0;
}

// A page has no host; all its processes, of which there is one, have the same.
int gethostname(char* name, size_t size) {
  if (size > 0) name[0] = '\0';
  return 0;
}
