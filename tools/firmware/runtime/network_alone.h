#ifndef DECID_FW_H
#define DECID_FW_H

#ifdef __cplusplus
extern "C" {
#endif

@CONSTANTS@
/* Return codes. */
enum {
  DECID_FW_OK = 0,
  DECID_FW_ERROR_NULL = -1,       /* a pointer is null */
  DECID_FW_ERROR_ALIGNMENT = -2,  /* the arena's address is no multiple of 8 */
  DECID_FW_ERROR_NOT_FINITE = -3, /* an input is infinite or NaN, or an output would be */
  DECID_FW_ERROR_SELF_TEST = -6   /* other bits than the program that made this file computed, or flushed subnormals */
};

/* Memory for one call at a time; its content need not be kept between them. A call must not interrupt another one with
   the same arena; different arenas are independent. */
typedef union {
  double align;
  unsigned char bytes[DECID_FW_ARENA_BYTES];
} DECID_FW_arena;

/* From DECID_FW_INPUT_CHANNELS x _ROWS x _COLUMNS values, channel-major, to DECID_FW_OUTPUTS, also channel-major, which
   are written only if the result is DECID_FW_OK. arena: DECID_FW_ARENA_BYTES, aligned to 8. */
int DECID_FW_run(const float *input, float *outputs, void *arena);

/* Runs a made-up input and compares all bits with those of the program that wrote this file: run it once on every new
   target and compiler. Needs the arena. */
int DECID_FW_self_test(void *arena);

#ifdef __cplusplus
}
#endif

#endif
