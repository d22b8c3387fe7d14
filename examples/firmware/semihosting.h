/* Files and text of the machine that runs the emulator (or a debugger): Arm's semihosting, "Semihosting for AArch32 and
   AArch64". A product has its own sensors and its own memory here. */
#ifndef SEMIHOSTING_H
#define SEMIHOSTING_H

#include <stdint.h>

/* Handle of a file, below 0 if there is none. */
int32_t host_open(const char* name, int32_t to_write);
/* 0 if all bytes were read or written. */
int32_t host_read(int32_t file, void* to, uint32_t bytes);
int32_t host_write(int32_t file, const void* from, uint32_t bytes);
int32_t host_length(int32_t file);
void host_close(int32_t file);
void host_print(const char* text);
/* Ends the emulation. */
void host_exit(int32_t code);

#endif
