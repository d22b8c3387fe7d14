
/* ---- Stability of other gains ---------------------------------------------------------------------------------------
   is_stable_with_unit_gains of decid's posterior/frf/stability.cpp, operation by operation: a root that comes
   from the left crosses the imaginary axis at one frequency only, and there the delay decides. With kp_pass above
   m g h + 2 kp roots may go back at a lower frequency, so that the loop is stable again at some longer delays; it
   counts as unstable there. As kp and kd grow together so does the frequency, and the longest stable delay falls. So a
   range of gains is stable if both ends are. Without damping the loop is not stable: rounding would decide. */

#define LARGEST_GAIN_OF_MGH 1e6 /* larger ones are no controller's, and lose the digits of the difference in square */

static int32_t is_stable(const DECID_FW_parameters* p, double gain, double delay) {
  const double inertia = DECID_FW_INERTIA_KGM2;
  const double lean = BODY_MGH - p->kp_pass;
  const double kp = gain * p->kp;
  const double kd = gain * p->kd;
  const double most = LARGEST_GAIN_OF_MGH * BODY_MGH;
  double half;
  double rest;
  double inside;
  double square;
  double w;
  if (((2.0 * kp) <= lean) || ((kd <= 0.0) && (p->kd_pass <= 0.0))) {
    return 0;
  }
  if ((kp > most) || (kd > most) || (p->kp_pass > most) || (p->kd_pass > most)) {
    return 0;
  }
  half = ((inertia * lean) + (0.5 * p->kd_pass * p->kd_pass)) - (2.0 * kd * kd);
  rest = (lean * lean) - (4.0 * kp * kp);
  inside = (half * half) - (inertia * inertia * rest);
  if (inside < 0.0) {
    return 1;
  }
  square = (square_root(inside) - half) / (inertia * inertia);
  if (square <= 0.0) {
    return 1;
  }
  w = square_root(square);
  return ((w * delay) < (angle_of(w * kd, kp) + angle_of(w * p->kd_pass, (inertia * square) + lean))) ? 1 : 0;
}

int DECID_FW_check(const DECID_FW_parameters* parameters, double delay_margin_s, double gain_margin) {
  const DECID_FW_parameters* const p = (parameters != NULL) ? parameters : &DECID_FW_identified;
  double delay;
  if ((are_parameters(p) == 0) || (is_between(delay_margin_s, LARGEST_DELAY_MARGIN_S) == 0) ||
      (is_between(gain_margin, LARGEST_GAIN_MARGIN) == 0) || (gain_margin < 1.0)) {
    return DECID_FW_ERROR_RANGE;
  }
  delay = (p->delay + DECID_FW_STEP_S) + delay_margin_s;
  if ((is_stable(p, 1.0 / gain_margin, delay) == 0) || (is_stable(p, gain_margin, delay) == 0)) {
    return DECID_FW_ERROR_UNSTABLE;
  }
  return DECID_FW_OK;
}
