/* From reset to main on a Cortex-M, and what compilers call without being asked. */
#include <stddef.h>
#include <stdint.h>

extern uint32_t data_source[], data_start[], data_end[], bss_start[], bss_end[], stack_low[], stack_top[];
int main(void);
void reset(void);
void fault(void);

void* memcpy(void* to, const void* from, size_t bytes) {
  unsigned char* const t = to;
  const unsigned char* const f = from;
  size_t i;
  for (i = 0; i < bytes; ++i) {
    t[i] = f[i];
  }
  return to;
}

void* memset(void* to, int value, size_t bytes) {
  unsigned char* const t = to;
  size_t i;
  for (i = 0; i < bytes; ++i) {
    t[i] = (unsigned char)value;
  }
  return to;
}

void fault(void) {
  for (;;) {
  }
}

void reset(void) {
  volatile uint32_t* const cpacr = (volatile uint32_t*)0xe000ed88U;
  uint32_t* to = data_start;
  const uint32_t* from = data_source;
  *cpacr |= 0xf00000U; /* the FPU, if there is one: full access */
  __asm__ volatile("dsb\n\tisb");
  while (to < data_end) {
    *to++ = *from++;
  }
  for (to = bss_start; to < bss_end; ++to) {
    *to = 0U;
  }
  (void)main();
  fault();
}

typedef void (*handler)(void);
typedef union {
  uint32_t* stack;
  handler code;
} vector;

__attribute__((section(".vectors"), used)) static const vector vectors[16] = {
    {.stack = stack_top}, {.code = reset}, {.code = fault}, {.code = fault}, {.code = fault}, {.code = fault},
    {.code = fault},      {.code = fault}, {.code = fault}, {.code = fault}, {.code = fault}, {.code = fault},
    {.code = fault},      {.code = fault}, {.code = fault}, {.code = fault}};
