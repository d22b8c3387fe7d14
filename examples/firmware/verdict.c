/* Judges an identification: may a product use it? See verdict.h. */
#include "verdict.h"

#include "posture.h"

static verdict worse(verdict a, verdict b) {
  return (a > b) ? a : b;
}

/* Returns 1 if the value is outside of the range by more than this part of its width, or is no number. */
static int is_beyond(float value, float low, float high, float part) {
  const float margin = part * (high - low);
  return ((value >= (low - margin)) && (value <= (high + margin))) ? 0 : 1;
}

verdict judge(int result, const float* parameters, void* arena) {
  static const float low[POSTURE_PARAMETERS] = POSTURE_MINIMA;
  static const float high[POSTURE_PARAMETERS] = POSTURE_MAXIMA;
  verdict found = VERDICT_USABLE;
  int i;
  if (result != POSTURE_OK) {
    return VERDICT_NOT_USABLE;
  }
  for (i = 0; i < POSTURE_PARAMETERS; ++i) {
    if (is_beyond(parameters[i], low[i], high[i], 0.05F) != 0) {
      const int is_impossible =
          ((parameters[i] < 0.0F) || (is_beyond(parameters[i], low[i], high[i], 1.0F) != 0)) ? 1 : 0;
      found = worse(found, (is_impossible != 0) ? VERDICT_NOT_USABLE : VERDICT_CAUTION);
    }
  }
#if POSTURE_GIVES_STDDEVS
  {
    static const int deciding[] = {POSTURE_KP, POSTURE_KD, POSTURE_DELAY}; /* whether the body stands */
    float stddevs[POSTURE_PARAMETERS];
    if (posture_stddevs(stddevs, arena) != POSTURE_OK) {
      return VERDICT_NOT_USABLE;
    }
    for (i = 0; i < 3; ++i) {
      const int p = deciding[i];
      found = worse(found, (stddevs[p] > (0.2F * (high[p] - low[p]))) ? VERDICT_CAUTION : VERDICT_USABLE);
    }
  }
#endif
#if POSTURE_GIVES_DISTANCE
  {
    double distance = 0.0;
    if ((posture_distance(&distance, arena) != POSTURE_OK) || (distance > POSTURE_DISTANCE_NOT_USABLE)) {
      return VERDICT_NOT_USABLE;
    }
    found = worse(found, (distance > 1.0) ? VERDICT_CAUTION : VERDICT_USABLE);
  }
#endif
  (void)arena;
  return found;
}
