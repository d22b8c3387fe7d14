/* ---- The controller -------------------------------------------------------------------------------------------------
   The controller of decid's simulator, operation by operation (sim/kernels/pendulums.hpp, where the equations are).
   With c = step / inertia, e half the difference between the tilt as estimated and the tilt, q = e' and nu the
   vestibular noise, the paper's controller is:
     q = (nu' - clamp(f' + nu', -theta, theta)) / 2,   u = 2 c Kp (a + e) + 2 c Kd (a' + q),   torque = -u(t - delay) /
   c
   UNIT_GAINS 0: servo, tilt estimate and gravity estimate have gains, and there are slow and torque feedback. */

static double clamped(double x, double low, double high) {
  const double below = (x < high) ? x : high;
  return (below > low) ? below : low;
}

/* The nearest whole number, for 0 <= x < 2^31. */
static double rounded(double x) {
  return (double)(int32_t)(x + 0.5);
}

#define MAGIC 0x64656332 /* of a state that has begun */

/* A compiler may leave out the first of two writes, but not of volatile ones. */
static void mark_begun(DECID_FW_state* state, int32_t begun) {
  volatile int32_t* const mark = &state->begun;
  *mark = begun;
}

static double not_a_number(void) {
  double_bits u;
  u.bits = 0x7ff8000000000000U;
  return u.value;
}

/* Returns 1 if x is from 0 to most. Bits exclude NaN: a compiler may remove a comparison with it. */
static int32_t is_between(double x, double most) {
  return ((is_finite(x) != 0) && (x >= 0.0) && (x <= most)) ? 1 : 0;
}

/* Returns 1 if x is a number whose size is at most most, by its bits, which grow with the size. */
static int32_t is_within(double x, double most) {
  const uint64_t size = 0x7fffffffffffffffU;
  return (int32_t)((bits_of(x) & size) <= bits_of(most));
}

static int32_t are_parameters(const DECID_FW_parameters* p) {
  return ((is_between(p->kp, LARGEST_GAIN) != 0) && (is_between(p->kd, LARGEST_GAIN) != 0) &&
          (is_between(p->kp_pass, LARGEST_GAIN) != 0) && (is_between(p->kd_pass, LARGEST_GAIN) != 0) &&
          (is_between(p->theta, LARGEST_GAIN) != 0) && (is_between(p->delay, DECID_FW_LONGEST_DELAY_S) != 0))
             ? 1
             : 0;
}

#if UNIT_GAINS
#define TILT_SCALE(state) 0.5 /* of noise, platform and threshold */
#else
#define TILT_SCALE(state) ((state)->tilt)

static int32_t are_gains(const DECID_FW_parameters* p) {
  return ((is_between(p->servo, LARGEST_GAIN) != 0) && (is_between(p->tilt_gain, LARGEST_GAIN) != 0) &&
          (is_between(p->gravity_gain, LARGEST_GAIN) != 0) && (is_between(p->slow_gain, LARGEST_GAIN) != 0) &&
          (is_between(p->torque_gain, LARGEST_GAIN) != 0))
             ? 1
             : 0;
}

static void begin_gains(DECID_FW_state* state, const DECID_FW_parameters* p) {
  state->kp = STEP_OVER_INERTIA * p->kp;
  state->kd = STEP_OVER_INERTIA * p->kd;
  state->reach = p->servo + p->gravity_gain;
  state->tilt = p->tilt_gain;
  state->tilt_over_servo = p->tilt_gain - p->servo;
  state->slow_gain = p->slow_gain;
  state->torque_gain = p->torque_gain / (STEP_OVER_INERTIA * BODY_MGH);
  state->theta = p->tilt_gain * p->theta;
  state->slow = 0.0;
  state->torque = 0.0;
  state->active = 0.0;
}
#endif

int DECID_FW_begin(DECID_FW_state* state, const DECID_FW_parameters* parameters) {
  const DECID_FW_parameters* const p = (parameters != NULL) ? parameters : &DECID_FW_identified;
  double steps;
  int32_t i;
  if (state == NULL) {
    return DECID_FW_ERROR_NULL;
  }
  if (are_parameters(p) == 0) {
    return DECID_FW_ERROR_RANGE;
  }
#if !UNIT_GAINS
  if (are_gains(p) == 0) {
    return DECID_FW_ERROR_RANGE;
  }
#endif
  mark_begun(state, 0); /* a step that interrupts this is refused */
#if UNIT_GAINS
  state->kp = 2.0 * STEP_OVER_INERTIA * p->kp;
  state->kd = 2.0 * STEP_OVER_INERTIA * p->kd;
  state->theta = 0.5 * p->theta;
#else
  begin_gains(state, p);
#endif
  state->passive = STEP_OVER_INERTIA * p->kp_pass;
  state->damping = STEP_OVER_INERTIA * p->kd_pass;
  /* A delay of whole steps is one, whatever the rounding of its product. */
  steps = p->delay * (double)DECID_FW_STEPS_PER_SECOND;
  if (((steps - rounded(steps)) < 1e-9) && ((rounded(steps) - steps) < 1e-9)) {
    steps = rounded(steps);
  }
  state->whole = (int32_t)steps;
  state->fraction = steps - (double)state->whole;
  state->first_step = state->whole + ((state->fraction > 0.0) ? 1 : 0);
  state->error = 0.0;
  state->newer = 0.0;
  state->step = 0;
  for (i = 0; i < DECID_FW_DELAY_STEPS; ++i) {
    state->commands[i] = 0.0;
  }
  mark_begun(state, MAGIC);
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
#if !UNIT_GAINS
  double slow_rate;
  double torque_rate;
  double slow;
  double torque;
#endif
  int32_t now;
  int32_t then;
  if ((state == NULL) || (scaled == NULL)) {
    return DECID_FW_ERROR_NULL;
  }
  if (state->begun != MAGIC) {
    return DECID_FW_ERROR_STATE;
  }
  noise = TILT_SCALE(state) * vestibular_rate;
  heard = (TILT_SCALE(state) * support_rate) + noise;
  q = noise - clamped(heard, -state->theta, state->theta);
#if UNIT_GAINS
  command = fma_double(state->kp, sway_rad + state->error, state->kd * (sway_rate + q));
#else
  q = q + (state->tilt_over_servo * support_rate);
  slow_rate = fma_double(state->slow_gain, sway_rad, -(SLOW_LEAK * state->slow));
  torque_rate = fma_double(state->torque_gain, state->active, -(TORQUE_LEAK * state->torque));
  command = fma_double(state->kp, fma_double(state->reach, sway_rad, state->error + (state->slow + state->torque)),
                       state->kd * fma_double(state->reach, sway_rate, q + (slow_rate + torque_rate)));
  slow = fma_double(slow_rate, DECID_FW_STEP_S, state->slow);
  torque = fma_double(torque_rate, DECID_FW_STEP_S, state->torque);
#endif
  error = fma_double(q, DECID_FW_STEP_S, state->error);
  now = state->step % DECID_FW_DELAY_STEPS;
  then = now - state->whole;
  if (then < 0) {
    then += DECID_FW_DELAY_STEPS;
  }
  newer = (then == now) ? command : state->commands[then]; /* without a whole delay what is being written */
  active = fma_double(state->fraction, state->newer - newer, newer);
  /* The threshold would hide a support's rate that is no number, and the delay line would keep one of the sway, or a
     command whose torque is infinite. */
  if ((is_finite(heard) == 0) || (is_finite(error) == 0) || (is_within(command, LARGEST_COMMAND) == 0) ||
      (is_finite(active) == 0)) {
    return DECID_FW_ERROR_NOT_FINITE;
  }
#if !UNIT_GAINS
  if ((is_finite(slow) == 0) || (is_finite(torque) == 0)) {
    return DECID_FW_ERROR_NOT_FINITE;
  }
#endif
  state->error = error;
  state->commands[now] = command;
  state->newer = newer;
  *scaled = (state->step < state->first_step) ? 0.0 : active;
#if !UNIT_GAINS
  state->slow = slow;
  state->torque = torque;
  state->active = *scaled;
#endif
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
  double torque;
  if ((state == NULL) || (state->begun != MAGIC)) {
    return not_a_number();
  }
  torque = -(((state->passive * ankle_rad) + (state->damping * ankle_rate)) / STEP_OVER_INERTIA);
  return (is_finite(torque) != 0) ? torque : not_a_number();
}

/* Twice e with gains of 1, as which it is kept there. */
#if UNIT_GAINS
#define TILT_ERRORS 2.0
#else
#define TILT_ERRORS 1.0
#endif

double DECID_FW_tilt_error(const DECID_FW_state* state) {
  if ((state == NULL) || (state->begun != MAGIC)) {
    return not_a_number();
  }
  return TILT_ERRORS * state->error;
}

int DECID_FW_set_tilt_error(DECID_FW_state* state, double tilt_error_rad) {
  int result = DECID_FW_OK;
  if (state == NULL) {
    result = DECID_FW_ERROR_NULL;
  } else if (state->begun != MAGIC) {
    result = DECID_FW_ERROR_STATE;
  } else if (is_finite(tilt_error_rad) == 0) {
    result = DECID_FW_ERROR_NOT_FINITE;
  } else {
    state->error = tilt_error_rad / TILT_ERRORS;
  }
  return result;
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

/* Returns 1 if NaN and an uninitialised state are refused. */
static int32_t refuses(DECID_FW_state* state) {
  DECID_FW_parameters p = DECID_FW_identified;
  double scaled = 0.0;
  int32_t input;
  int32_t refused = 1;
  p.delay = not_a_number();
  state->begun = 0;
  if ((DECID_FW_begin(state, &p) != DECID_FW_ERROR_RANGE) ||
      (DECID_FW_step_scaled(state, 0.0, 0.0, 0.0, 0.0, &scaled) != DECID_FW_ERROR_STATE) ||
      (DECID_FW_begin(state, NULL) != DECID_FW_OK)) {
    refused = 0;
  }
  for (input = 0; (input < 4) && (refused != 0); ++input) {
    double inputs[4] = {0.0, 0.0, 0.0, 0.0};
    inputs[input] = not_a_number();
    if (DECID_FW_step_scaled(state, inputs[0], inputs[1], inputs[2], inputs[3], &scaled) != DECID_FW_ERROR_NOT_FINITE) {
      refused = 0;
    }
  }
  return refused;
}

#if UNIT_GAINS
/* Returns 1 if the check of gains finds the header's margins: both borders, unless one is where their search ends. */
static int32_t finds_margins(void) {
  int32_t found = (DECID_FW_check(NULL, 0.0, 1.0) == CHECK_OF_IDENTIFIED) ? 1 : 0;
#if TESTS_DELAY_MARGIN
  if ((DECID_FW_check(NULL, DECID_FW_DELAY_MARGIN_S - 1e-6, 1.0) != DECID_FW_OK) ||
      (DECID_FW_check(NULL, DECID_FW_DELAY_MARGIN_S + 1e-6, 1.0) != DECID_FW_ERROR_UNSTABLE)) {
    found = 0;
  }
#endif
#if TESTS_GAIN_MARGIN
  if ((DECID_FW_check(NULL, 0.0, NEARER_GAIN_MARGIN - 1e-6) != DECID_FW_OK) ||
      (DECID_FW_check(NULL, 0.0, NEARER_GAIN_MARGIN + 1e-6) != DECID_FW_ERROR_UNSTABLE)) {
    found = 0;
  }
#endif
  return found;
}
#endif

int DECID_FW_self_test(DECID_FW_state* state) {
  double sway = 0.0;
  double rate = 0.0;
  uint64_t hash = 14695981039346656037U;
  const double stiffness = STEP_OVER_INERTIA * (BODY_MGH - DECID_FW_identified.kp_pass);
  int32_t interval;
  int32_t i;
  int32_t step = 0;
  int result = DECID_FW_begin(state, NULL);
  if ((result == DECID_FW_OK) && ((keeps_subnormals() == 0) || (refuses(state) == 0))) {
    result = DECID_FW_ERROR_SELF_TEST;
  }
#if UNIT_GAINS
  if ((result == DECID_FW_OK) && (finds_margins() == 0)) {
    result = DECID_FW_ERROR_SELF_TEST;
  }
#endif
  for (interval = 0; (interval < TEST_INTERVALS) && (result == DECID_FW_OK); ++interval) {
    const double tilt_rate = test_rate[interval];
    const double drive_slope = state->passive * (tilt_rate * DECID_FW_STEP_S);
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
      sway = fma_double(next, DECID_FW_STEP_S, sway);
    }
  }
  if (state != NULL) {
    state->begun = 0; /* not at rest: to be begun again */
  }
  return ((result == DECID_FW_OK) && (hash != TEST_HASH)) ? DECID_FW_ERROR_SELF_TEST : result;
}
