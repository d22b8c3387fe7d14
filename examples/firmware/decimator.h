/* From a sensor's 1 kHz to a model's 100 Hz: a moving average of ten samples, taken twice (a CIC filter of order 2). */
#ifndef DECIMATOR_H
#define DECIMATOR_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define DECIMATOR_FACTOR 10
#define DECIMATOR_TAPS ((2 * DECIMATOR_FACTOR) - 1)
#define DECIMATOR_DELAY_SAMPLES (DECIMATOR_FACTOR - 1) /* of the sensor, at all frequencies: 9 ms */

typedef struct {
  float last[DECIMATOR_TAPS]; /* the newest sample first */
  int32_t until_next;
} decimator;

/* Begins with the sample at the stimulus' start; before it the body stood upright. */
void decimator_begin(decimator* state);

/* Takes a sample. Returns 1 with every tenth one and writes a value: the first with sample 9, for the time of sample 0.
   So value k is for the time 10 k ms, and comes 9 ms later. Feed it as sample k of the trial, and nothing is delayed.
 */
int decimator_take(decimator* state, float sample, float* value);

#ifdef __cplusplus
}
#endif

#endif
