#ifndef DECID_FW_H
#define DECID_FW_H

#ifdef __cplusplus
extern "C" {
#endif

@CONSTANTS@
/* The body for which the model answers: what is above the ankles, its centre of mass above them, and its moment of
   inertia about them. Compare them with your machine's, and with an exported controller's, which has the same names. */
@BODY@
/* The range of each parameter for this body, in the unit below: the model was trained on it. Limit a result to it. A
   result that is outside of it by more than a twentieth of its width is doubtful. */
@RANGES@
/* Return codes. */
enum {
  DECID_FW_OK = 0,
  DECID_FW_MORE = 1,              /* there is more work that can be done now */
  DECID_FW_ERROR_NULL = -1,       /* a pointer is null */
  DECID_FW_ERROR_ALIGNMENT = -2,  /* the arena's address is no multiple of 8 */
  DECID_FW_ERROR_NOT_FINITE = -3, /* a sample or a pixel is infinite or NaN, or so large that a result would be */
  DECID_FW_ERROR_STATE = -4,      /* not begun, or the result is not there yet */
  DECID_FW_ERROR_COUNT = -5,      /* more samples than the trial has left, or fewer than none */
  DECID_FW_ERROR_SELF_TEST = -6   /* other bits than the program that made this file computed, or flushed subnormals */
};

/* Places of the parameters. */
enum {
@PLACES@};

/* Memory for one identification at a time; its content need not be kept between them. A call must not interrupt another
   one with the same arena, as a timer's interrupt does that feeds while the main loop works: the trial would be wrong,
   without an error. Calls with different arenas are independent. */
typedef union {
  double align;
  unsigned char bytes[DECID_FW_ARENA_BYTES];
} DECID_FW_arena;

/* From a trial to its parameters. sway_rad: DECID_FW_SAMPLES samples at DECID_FW_RATE_HZ, 0 upright, positive in
   the direction of the platform's tilt, from the stimulus' start on. parameters: DECID_FW_PARAMETERS values, written
   only if the result is DECID_FW_OK. A network may answer a little outside of a parameter's range, also below 0: limit
   the values (DECID_FW_MINIMA, DECID_FW_MAXIMA) before you use them. arena: DECID_FW_ARENA_BYTES, aligned to 8. */
int DECID_FW_identify(const float *sway_rad, float *parameters, void *arena);

/* The same from the network's input: DECID_FW_IMAGE_CHANNELS x _ROWS x _COLUMNS values, row scaling applied. */
int DECID_FW_identify_image(const float *image, float *parameters, void *arena);
@DEVIATIONS@@FAMILIARITY@@INCREMENTAL@
/* Identifies a made-up sway and compares all bits with those of the program that wrote this file: run it once on every
   new target and compiler. Needs the arena, and leaves no result in it. */
int DECID_FW_self_test(void *arena);

#ifdef __cplusplus
}
#endif

#endif
