/* ---- The controller -------------------------------------------------------------------------------------------------
   The DEC controller of decid's simulator, operation by operation (sim/kernels/pendulums.hpp, where the equations are).
   With c = step / inertia, e half the difference between the tilt as estimated and the tilt, q = e' and nu the
   vestibular noise:
     q = (nu' - clamp(f' + nu', -theta, theta)) / 2,   u = 2 c Kp (a + e) + 2 c Kd (a' + q),   torque = -u(t - delay) /
   c */

static double clamped(double x, double low, double high) {
  const double below = (x < high) ? x : high;
  return (below > low) ? below : low;
}

/* The nearest whole number, for 0 <= x < 2^31. */
static double rounded(double x) {
  return (double)(int32_t)(x + 0.5);
}

int DECID_FW_begin(DECID_FW_state* state, const DECID_FW_parameters* parameters) {
  const DECID_FW_parameters* const p = (parameters != NULL) ? parameters : &DECID_FW_identified;
  double steps;
  int32_t i;
  if (state == NULL) {
    return DECID_FW_ERROR_NULL;
  }
  if (!((p->kp >= 0.0) && (p->kp <= LARGEST_GAIN) && (p->kd >= 0.0) && (p->kd <= LARGEST_GAIN) && (p->kp_pass >= 0.0) &&
        (p->kp_pass <= LARGEST_GAIN) && (p->kd_pass >= 0.0) && (p->kd_pass <= LARGEST_GAIN) && (p->theta >= 0.0) &&
        (p->theta <= LARGEST_GAIN) && (p->delay >= 0.0) && (p->delay <= DECID_FW_LONGEST_DELAY_S))) {
    return DECID_FW_ERROR_RANGE;
  }
  state->kp = 2.0 * STEP_OVER_INERTIA * p->kp;
  state->kd = 2.0 * STEP_OVER_INERTIA * p->kd;
  state->passive = STEP_OVER_INERTIA * p->kp_pass;
  state->damping = STEP_OVER_INERTIA * p->kd_pass;
  state->theta = 0.5 * p->theta;
  /* A delay of whole milliseconds is one, whatever the rounding of its product. */
  steps = p->delay * 1000.0;
  if (((steps - rounded(steps)) < 1e-9) && ((rounded(steps) - steps) < 1e-9)) {
    steps = rounded(steps);
  }
  state->whole = (int)steps;
  state->fraction = steps - (double)state->whole;
  state->first_step = state->whole + ((state->fraction > 0.0) ? 1 : 0);
  state->error = 0.0;
  state->newer = 0.0;
  state->step = 0;
  for (i = 0; i < DECID_FW_DELAY_STEPS; ++i) {
    state->commands[i] = 0.0;
  }
  return DECID_FW_OK;
}

int DECID_FW_step_scaled(DECID_FW_state* state, double sway_rad, double sway_rate, double support_rate,
                         double vestibular_rate, double* scaled) {
  double noise;
  double heard;
  double q;
  double error;
  double command;
  double newer;
  double active;
  int now;
  int then;
  if ((state == NULL) || (scaled == NULL)) {
    return DECID_FW_ERROR_NULL;
  }
  noise = 0.5 * vestibular_rate;
  heard = (0.5 * support_rate) + noise;
  q = noise - clamped(heard, -state->theta, state->theta);
  error = fma_double(q, 0.001, state->error);
  command = fma_double(state->kp, sway_rad + state->error, state->kd * (sway_rate + q));
  now = state->step % DECID_FW_DELAY_STEPS;
  then = now - state->whole;
  if (then < 0) {
    then += DECID_FW_DELAY_STEPS;
  }
  newer = (then == now) ? command : state->commands[then]; /* without a whole delay what is being written */
  active = fma_double(state->fraction, state->newer - newer, newer);
  /* The threshold would hide a support's rate that is no number, and the delay line would keep one of the sway. */
  if ((is_finite(heard) == 0) || (is_finite(error) == 0) || (is_finite(command) == 0) || (is_finite(active) == 0)) {
    return DECID_FW_ERROR_NOT_FINITE;
  }
  state->error = error;
  state->commands[now] = command;
  state->newer = newer;
  *scaled = (state->step < state->first_step) ? 0.0 : active;
  ++state->step;
  /* The ring's index goes on without a jump; first_step is behind by then. */
  if (state->step == (1000000 * DECID_FW_DELAY_STEPS)) {
    state->step = 2 * DECID_FW_DELAY_STEPS;
  }
  return DECID_FW_OK;
}

int DECID_FW_step(DECID_FW_state* state, double sway_rad, double sway_rate, double support_rate, double vestibular_rate,
                  double* torque) {
  const int result = DECID_FW_step_scaled(state, sway_rad, sway_rate, support_rate, vestibular_rate, torque);
  if (result == DECID_FW_OK) {
    *torque = -(*torque / STEP_OVER_INERTIA);
  }
  return result;
}

double DECID_FW_passive(const DECID_FW_state* state, double ankle_rad, double ankle_rate) {
  return -(((state->passive * ankle_rad) + (state->damping * ankle_rate)) / STEP_OVER_INERTIA);
}

/* ---- A simulated body, for the self-test ----------------------------------------------------------------------------
 */

static uint64_t hash_of(uint64_t before, double value) {
  union {
    double value;
    uint64_t bits;
  } u;
  u.value = value;
  return (before ^ u.bits) * 1099511628211U;
}

int DECID_FW_self_test(DECID_FW_state* state) {
  double sway = 0.0;
  double rate = 0.0;
  uint64_t hash = 14695981039346656037U;
  const double stiffness = STEP_OVER_INERTIA * (BODY_MGH - DECID_FW_identified.kp_pass);
  int32_t interval;
  int32_t i;
  int32_t step = 0;
  int result = DECID_FW_begin(state, NULL);
  for (interval = 0; (interval < TEST_INTERVALS) && (result == DECID_FW_OK); ++interval) {
    const double tilt_rate = test_rate[interval];
    const double drive_slope = state->passive * (tilt_rate * 0.001);
    double drive = fma_double(state->passive, test_tilt[interval], state->damping * tilt_rate);
    for (i = 0; (i < STEPS_PER_INTERVAL) && (result == DECID_FW_OK); ++i) {
      const double z = sway * sway;
      const double sine = fma_double(fma_double(SINE_2, z, SINE_1), z, SINE_0);
      double active = 0.0;
      double next;
      if ((step % STEPS_PER_SAMPLE) == 0) {
        hash = hash_of(hash, sway);
      }
      ++step;
      result = DECID_FW_step_scaled(state, sway, rate, tilt_rate, 0.0, &active);
      next = fma_double(1.0 - state->damping, rate, drive - active);
      drive = drive + drive_slope;
      next = fma_double(stiffness, sway, next);
      next = fma_double(sway * z, sine, next);
      rate = next;
      sway = fma_double(next, 0.001, sway);
    }
  }
  return ((result == DECID_FW_OK) && (hash != TEST_HASH)) ? DECID_FW_ERROR_SELF_TEST : result;
}
