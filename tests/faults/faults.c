/* Preloaded into a program, makes one call of a function of the system fail: call number N of FUNCTION, with ERRNO.
     DECID_FAULT=FUNCTION:N:ERRNO    N from 1; ERRNO as a number
     DECID_FAULT_COUNT=FILE          writes how often each function was called when the process ends: "write 12"
   Calls are counted over all threads. Calls within the C library (a stream's write) do not come here;
   hence fopen, fread and fclose are functions of their own. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

enum function {
  OPEN,
  READ,
  PREAD,
  WRITE,
  PWRITEV,
  FTRUNCATE,
  FSYNC,
  RENAME,
  CLOSE,
  FSTAT,
  MKDIR,
  FLOCK,
  FOPEN,
  FREAD,
  FCLOSE,
  FORK,
  PIPE,
  ALLOCATE,
  FUNCTIONS
};
static const char* const names[FUNCTIONS] = {"open",  "read",   "pread",  "write", "pwritev", "ftruncate",
                                             "fsync", "rename", "close",  "fstat", "mkdir",   "flock",
                                             "fopen", "fread",  "fclose", "fork",  "pipe",    "allocate"};
static atomic_long counts[FUNCTIONS];
static int failing = -1;
static long failing_call;
static int failing_errno;

__attribute__((constructor)) static void read_settings(void) {
  const char* text = getenv("DECID_FAULT");
  char name[32];
  if (text == NULL || sscanf(text, "%31[a-z]:%ld:%d", name, &failing_call, &failing_errno) != 3) return;
  for (int i = 0; i < FUNCTIONS; ++i)
    if (strcmp(name, names[i]) == 0) failing = i;
  for (int i = 0; i < FUNCTIONS; ++i) counts[i] = 0;
}

__attribute__((destructor)) static void write_counts(void) {
  const char* path = getenv("DECID_FAULT_COUNT");
  failing = -1;
  if (path == NULL) return;
  FILE* file = fopen(path, "w");
  if (file == NULL) return;
  for (int i = 0; i < FUNCTIONS; ++i) fprintf(file, "%s %ld\n", names[i], (long)counts[i]);
  fclose(file);
}

static int fails(enum function which) {
  const long call = atomic_fetch_add(&counts[which], 1) + 1;
  if ((int)which != failing || call != failing_call) return 0;
  errno = failing_errno;
  return 1;
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

int open(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = va_arg(list, mode_t);
  va_end(list);
  return fails(OPEN) ? -1 : REAL(open)(path, flags, mode);
}
int openat(int folder, const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = va_arg(list, mode_t);
  va_end(list);
  return fails(OPEN) ? -1 : REAL(openat)(folder, path, flags, mode);
}
ssize_t read(int file, void* to, size_t bytes) {
  return fails(READ) ? -1 : REAL(read)(file, to, bytes);
}
ssize_t pread(int file, void* to, size_t bytes, off_t at) {
  return fails(PREAD) ? -1 : REAL(pread)(file, to, bytes, at);
}
ssize_t write(int file, const void* from, size_t bytes) {
  return fails(WRITE) ? -1 : REAL(write)(file, from, bytes);
}
ssize_t pwritev(int file, const struct iovec* pieces, int count, off_t at) {
  return fails(PWRITEV) ? -1 : REAL(pwritev)(file, pieces, count, at);
}
int ftruncate(int file, off_t bytes) {
  return fails(FTRUNCATE) ? -1 : REAL(ftruncate)(file, bytes);
}
int fsync(int file) {
  return fails(FSYNC) ? -1 : REAL(fsync)(file);
}
int rename(const char* from, const char* to) {
  return fails(RENAME) ? -1 : REAL(rename)(from, to);
}
int close(int file) {
  const int result = REAL(close)(file);
  return fails(CLOSE) ? -1 : result;
}
int fstat(int file, struct stat* status) {
  return fails(FSTAT) ? -1 : REAL(fstat)(file, status);
}
int mkdir(const char* path, mode_t mode) {
  return fails(MKDIR) ? -1 : REAL(mkdir)(path, mode);
}
int flock(int file, int operation) {
  return fails(FLOCK) ? -1 : REAL(flock)(file, operation);
}
FILE* fopen(const char* path, const char* mode) {
  return fails(FOPEN) ? NULL : REAL(fopen)(path, mode);
}
size_t fread(void* to, size_t size, size_t count, FILE* file) {
  if (!fails(FREAD)) return REAL(fread)(to, size, count, file);
  file->_flags |= 0x20; /* glibc's _IO_ERR_SEEN: what ferror() tells */
  return 0;
}
int fclose(FILE* file) {
  const int result = REAL(fclose)(file);
  return fails(FCLOSE) ? EOF : result;
}
pid_t fork(void) {
  return fails(FORK) ? -1 : REAL(fork)();
}
int pipe2(int ends[2], int flags) {
  return fails(PIPE) ? -1 : REAL(pipe2)(ends, flags);
}

/* glibc's own functions behind its public ones: dlsym allocates, so it cannot be asked for these. */
void* __libc_malloc(size_t bytes);
void* __libc_calloc(size_t count, size_t bytes);
void* __libc_realloc(void* old, size_t bytes);
void* __libc_memalign(size_t alignment, size_t bytes);

void* malloc(size_t bytes) {
  return fails(ALLOCATE) ? NULL : __libc_malloc(bytes);
}
void* calloc(size_t count, size_t bytes) {
  return fails(ALLOCATE) ? NULL : __libc_calloc(count, bytes);
}
void* realloc(void* old, size_t bytes) {
  return fails(ALLOCATE) ? NULL : __libc_realloc(old, bytes);
}
void* aligned_alloc(size_t alignment, size_t bytes) {
  return fails(ALLOCATE) ? NULL : __libc_memalign(alignment, bytes);
}
int posix_memalign(void** place, size_t alignment, size_t bytes) {
  if (fails(ALLOCATE)) return ENOMEM;
  *place = __libc_memalign(alignment, bytes);
  return *place == NULL ? ENOMEM : 0;
}
