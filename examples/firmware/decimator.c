/* From a sensor's 1 kHz to a model's 100 Hz: see decimator.h. */
#include "decimator.h"

void decimator_begin(decimator* state) {
  int32_t i;
  for (i = 0; i < DECIMATOR_TAPS; ++i) {
    state->last[i] = 0.0F;
  }
  state->until_next = DECIMATOR_FACTOR;
}

int decimator_take(decimator* state, float sample, float* value) {
  float sum = 0.0F;
  int32_t i;
  for (i = DECIMATOR_TAPS - 1; i > 0; --i) {
    state->last[i] = state->last[i - 1];
  }
  state->last[0] = sample;
  --state->until_next;
  if (state->until_next > 0) {
    return 0;
  }
  state->until_next = DECIMATOR_FACTOR;
  for (i = 0; i < DECIMATOR_TAPS; ++i) {
    const int32_t weight = (i < DECIMATOR_FACTOR) ? (i + 1) : (DECIMATOR_TAPS - i);
    sum = sum + ((float)weight * state->last[i]);
  }
  *value = sum / (float)(DECIMATOR_FACTOR * DECIMATOR_FACTOR);
  return 1;
}
