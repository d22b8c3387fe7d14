/* Judges an identification: may a product use it? Copy verdict.h and verdict.c, and put your
   model's name for posture. */
#ifndef VERDICT_H
#define VERDICT_H

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
  VERDICT_USABLE = 0,    /* no reason against it */
  VERDICT_CAUTION = 1,   /* it may be wrong: keep the old controller, and identify again */
  VERDICT_NOT_USABLE = 2 /* do not use it */
} verdict;

/* Judges a trial. result: what posture_identify() or posture_result() returned, with these parameters and this arena.
   Call it before the arena is used again. Not usable:
   - a return code other than POSTURE_OK,
   - a parameter below 0 that is also outside of its range by more than a twentieth of it, or one outside of its range
     by more than its whole width,
   - with --ood-score: a distance above POSTURE_DISTANCE_NOT_USABLE.
   Caution:
   - a parameter outside of its range by more than a twentieth of it,
   - for a model with standard deviations: one of Kp, Kd or the delay above a fifth of its range (knowing nothing is
   0.29),
   - with --ood-score: a distance above 1, as 3 of 100 simulated trials have. POSTURE_DISTANCE_USABLE is stricter.
   Without --ood-score it does not notice a trial of another stimulus, start, sign or rate. */
verdict judge(int result, const float* parameters, void* arena);

#ifdef __cplusplus
}
#endif

#endif
