/* Semihosting: see semihosting.h. */
#include "semihosting.h"

enum {
  SYS_OPEN = 0x01,
  SYS_CLOSE = 0x02,
  SYS_WRITE0 = 0x04,
  SYS_WRITE = 0x05,
  SYS_READ = 0x06,
  SYS_FLEN = 0x0c,
  SYS_EXIT_EXTENDED = 0x20
};

static int32_t call(int32_t operation, const void* argument) {
  register int32_t r0 __asm__("r0") = operation;
  register const void* r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

int32_t host_open(const char* name, int32_t to_write) {
  uint32_t block[3];
  uint32_t length = 0U;
  while (name[length] != '\0') {
    ++length;
  }
  block[0] = (uint32_t)(uintptr_t)name;
  block[1] = (to_write != 0) ? 5U : 1U; /* "wb", "rb" */
  block[2] = length;
  return call(SYS_OPEN, block);
}

static int32_t transfer(int32_t operation, int32_t file, uintptr_t at, uint32_t bytes) {
  uint32_t block[3];
  block[0] = (uint32_t)file;
  block[1] = (uint32_t)at;
  block[2] = bytes;
  return call(operation, block);
}

int32_t host_read(int32_t file, void* to, uint32_t bytes) {
  return transfer(SYS_READ, file, (uintptr_t)to, bytes);
}

int32_t host_write(int32_t file, const void* from, uint32_t bytes) {
  return transfer(SYS_WRITE, file, (uintptr_t)from, bytes);
}

int32_t host_length(int32_t file) {
  return call(SYS_FLEN, &file);
}

void host_close(int32_t file) {
  (void)call(SYS_CLOSE, &file);
}

void host_print(const char* text) {
  (void)call(SYS_WRITE0, text);
}

void host_exit(int32_t code) {
  uint32_t block[2];
  block[0] = 0x20026U; /* ADP_Stopped_ApplicationExit */
  block[1] = (uint32_t)code;
  (void)call(SYS_EXIT_EXTENDED, block);
}
