/* Lets an exported controller, called controller, balance the simulator's body for a whole trial and writes its sway.
   Usage: harness trial.bin sway.bin. trial.bin, doubles: step over inertia, m g h, three coefficients of the sine,
   kp_pass, kd_pass; samples, steps a sample, intervals a sample; factor of the noise; torque at rest over kp and sway,
   or NaN; tilt and rate of each interval; noise rate at each sample and at the end. The body's operations are those of
   sim/kernels/pendulums.hpp. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "controller.h"

static int failures = 0;
#define REQUIRE(condition) require((condition), #condition, __LINE__)

static void require(int holds, const char* what, int line) {
  if (!holds) {
    ++failures;
    printf("line %d: %s does not hold\n", line, what);
  }
}

static controller_state state;

static void check_errors(void) {
  controller_parameters p = controller_identified;
  REQUIRE(controller_begin(NULL, NULL) == CONTROLLER_ERROR_NULL);
  REQUIRE(controller_self_test(NULL) == CONTROLLER_ERROR_NULL);
  REQUIRE(controller_begin(&state, &p) == CONTROLLER_OK);
  p.delay = 1.0;
  REQUIRE(controller_begin(&state, &p) == CONTROLLER_OK);
  p.delay = 1.001;
  REQUIRE(controller_begin(&state, &p) == CONTROLLER_ERROR_RANGE);
  p.delay = -0.001;
  REQUIRE(controller_begin(&state, &p) == CONTROLLER_ERROR_RANGE);
  p = controller_identified;
  p.kd = NAN;
  REQUIRE(controller_begin(&state, &p) == CONTROLLER_ERROR_RANGE);
  p = controller_identified;
  p.theta = INFINITY;
  REQUIRE(controller_begin(&state, &p) == CONTROLLER_ERROR_RANGE);
}

/* The torque is the scaled command's, in N m, and acts against sway. */
static void check_torque(double responses) {
  static controller_state other;
  int i;
  REQUIRE(controller_begin(&state, NULL) == CONTROLLER_OK && controller_begin(&other, NULL) == CONTROLLER_OK);
  for (i = 0; i < 2000; ++i) {
    const double expected = -responses * controller_identified.kp * 0.01;
    double torque = NAN, scaled = NAN;
    REQUIRE(controller_step(&state, 0.01, 0.0, 0.0, 0.0, &torque) == CONTROLLER_OK);
    REQUIRE(controller_step_scaled(&other, 0.01, 0.0, 0.0, 0.0, &scaled) == CONTROLLER_OK);
    REQUIRE(fabs(torque + scaled * CONTROLLER_INERTIA_KGM2 * 1000.0) <= 1e-12 * fabs(torque));
    if (i > 1000 && !isnan(responses)) REQUIRE(fabs(torque - expected) <= 1e-9 * fabs(expected));
  }
  REQUIRE(fabs(controller_passive(&state, 0.01, 0.02) +
               (controller_identified.kp_pass * 0.01 + controller_identified.kd_pass * 0.02)) < 1e-9);
}

/* A step whose input is no number, or makes one, is none: the bytes of the state stay, also with a delay of 0. */
static void check_not_finite(double delay) {
  static const double bad[] = {NAN, INFINITY, -INFINITY};
  static controller_state before;
  controller_parameters p = controller_identified;
  size_t input, value;
  int i;
  double torque = 0.0;
  p.delay = delay;
  REQUIRE(controller_begin(&state, &p) == CONTROLLER_OK);
  for (i = 0; i < 500; ++i)
    REQUIRE(controller_step(&state, 0.01, 0.02, 0.001 * (i % 7), 0.0, &torque) == CONTROLLER_OK);
  memcpy(&before, &state, sizeof state);
  torque = 7.0;
  for (input = 0; input < 4; ++input) {
    for (value = 0; value < 3; ++value) {
      double with[4] = {0.01, 0.02, 0.003, 0.0};
      with[input] = bad[value];
      REQUIRE(controller_step(&state, with[0], with[1], with[2], with[3], &torque) == CONTROLLER_ERROR_NOT_FINITE);
      REQUIRE(controller_step_scaled(&state, with[0], with[1], with[2], with[3], &torque) ==
              CONTROLLER_ERROR_NOT_FINITE);
    }
  }
  REQUIRE(controller_step(&state, 0.0, 1.7e308, 0.0, 1.7e308, &torque) == CONTROLLER_ERROR_NOT_FINITE);
  REQUIRE(controller_step(NULL, 0.0, 0.0, 0.0, 0.0, &torque) == CONTROLLER_ERROR_NULL);
  REQUIRE(controller_step(&state, 0.0, 0.0, 0.0, 0.0, NULL) == CONTROLLER_ERROR_NULL);
  REQUIRE(torque == 7.0 && memcmp(&before, &state, sizeof state) == 0);
  REQUIRE(controller_step(&state, 0.01, 0.02, 0.003, 0.0, &torque) == CONTROLLER_OK && torque != 7.0);
}

/* A second state with the first one's tilt error has its torque; setting the error leaves the delay line. */
static void check_tilt_error(void) {
  static controller_state other, unset, never;
  const double bad[] = {NAN, INFINITY, -INFINITY};
  double torque = 0.0, second = 0.0, error;
  int i, changed = -1;
  REQUIRE(controller_begin(&state, NULL) == CONTROLLER_OK && controller_tilt_error(&state) == 0.0);
  for (i = 0; i < 3000; ++i) REQUIRE(controller_step(&state, 0.01, 0.0, 0.0005, 0.0, &torque) == CONTROLLER_OK);
  error = controller_tilt_error(&state);
  REQUIRE(isfinite(error) && (controller_identified.theta == 0.0 || fabs(error) > 1e-5));
  for (i = 0; i < 3; ++i) REQUIRE(controller_set_tilt_error(&state, bad[i]) == CONTROLLER_ERROR_NOT_FINITE);
  REQUIRE(controller_tilt_error(&state) == error);
  REQUIRE(controller_set_tilt_error(NULL, 0.0) == CONTROLLER_ERROR_NULL && isnan(controller_tilt_error(NULL)));
  REQUIRE(controller_set_tilt_error(&never, 0.0) == CONTROLLER_ERROR_STATE && isnan(controller_tilt_error(&never)));
  other = state;
  unset = state;
  REQUIRE(controller_set_tilt_error(&other, error + 0.01) == CONTROLLER_OK);
  REQUIRE(fabs(controller_tilt_error(&other) - (error + 0.01)) < 1e-15);
  for (i = 0; i < 1001; ++i) {
    REQUIRE(controller_step(&unset, 0.01, 0.0, 0.0, 0.0, &torque) == CONTROLLER_OK);
    REQUIRE(controller_step(&other, 0.01, 0.0, 0.0, 0.0, &second) == CONTROLLER_OK);
    if (changed < 0 && second != torque) changed = i;
    /* From one delay on it is kp times the change; interpolated in one step, and without feedback of the torque. */
    if (changed >= 0 && i == changed + 1)
      REQUIRE(fabs((second - torque) + controller_identified.kp * 0.01) < 1e-6 * controller_identified.kp);
  }
  REQUIRE(changed == (int)(controller_identified.delay * 1000.0 + 1e-9));
}

/* A finite outlier of the sway is a command like any other: its torque comes one delay later, and it is gone after one
   step more if nothing integrates it. With gains of its own a controller may integrate it for longer. */
static void check_outlier(double responses) {
  static controller_state other;
  double torque = 0.0, of_other = 0.0, largest = 0.0;
  const int delay = (int)(controller_identified.delay * 1000.0 + 1e-9);
  int i;
  REQUIRE(controller_begin(&state, NULL) == CONTROLLER_OK && controller_begin(&other, NULL) == CONTROLLER_OK);
  for (i = 0; i < 1500; ++i) {
    REQUIRE(controller_step(&state, 0.01, 0.0, 0.0, 0.0, &torque) == CONTROLLER_OK);
    REQUIRE(controller_step(&other, (i == 300) ? 1.01 : 0.01, 0.0, 0.0, 0.0, &of_other) == CONTROLLER_OK);
    if (i < 300 + delay) REQUIRE(of_other == torque);
    largest = fmax(largest, torque - of_other);
    if (!isnan(responses) && i > 301 + delay) REQUIRE(of_other == torque);
  }
  if (!isnan(responses)) {
    const double all = responses * controller_identified.kp;
    REQUIRE(largest >= 0.499 * all && largest <= 1.001 * all);
  }
}

/* After the self-test, which leaves no rest, the state must be begun. */
static void check_after_self_test(void) {
  double torque = 7.0;
  REQUIRE(controller_self_test(&state) == CONTROLLER_OK);
  REQUIRE(controller_step(&state, 0.0, 0.0, 0.0, 0.0, &torque) == CONTROLLER_ERROR_STATE && torque == 7.0);
  REQUIRE(isnan(controller_passive(&state, 0.01, 0.0)));
}

int main(int argc, char** argv) {
  FILE *in, *out;
  double head[12], sway = 0.0, rate = 0.0, noise;
  double *stimulus, *noise_rate;
  size_t samples, sample, intervals, interval;
  int steps, i;
  if (argc != 3) return 2;
  in = fopen(argv[1], "rb");
  out = fopen(argv[2], "wb");
  if (in == NULL || out == NULL || fread(head, sizeof head, 1, in) != 1) return 2;
  samples = (size_t)head[7];
  intervals = (size_t)head[9];
  steps = (int)(head[8] / head[9]);
  stimulus = (double*)malloc(samples * intervals * 2 * sizeof(double));
  noise_rate = (double*)malloc((samples + 1) * sizeof(double));
  if (stimulus == NULL || noise_rate == NULL) return 2;
  if (fread(stimulus, sizeof(double), samples * intervals * 2, in) != samples * intervals * 2) return 2;
  if (fread(noise_rate, sizeof(double), samples + 1, in) != samples + 1) return 2;
  check_after_self_test();
  check_tilt_error();
  check_errors();
  check_torque(head[11]);
  check_outlier(head[11]);
  check_not_finite(controller_identified.delay);
  check_not_finite(0.0);
  REQUIRE(controller_begin(&state, NULL) == CONTROLLER_OK);
  noise = head[10] * noise_rate[0];
  for (sample = 0; sample < samples; ++sample) {
    const double next_noise = head[10] * noise_rate[sample + 1];
    const double slope = (next_noise - noise) * (1.0 / head[8]);
    if (fwrite(&sway, sizeof sway, 1, out) != 1) return 2;
    for (interval = 0; interval < intervals; ++interval) {
      const double* const now = &stimulus[2 * (sample * intervals + interval)];
      const double passive = head[0] * head[5], damping = head[0] * head[6];
      double drive = fma(passive, now[0], damping * now[1]);
      const double drive_slope = passive * (now[1] * 0.001);
      for (i = 0; i < steps; ++i) {
        const double z = sway * sway, sine = fma(fma(head[4], z, head[3]), z, head[2]);
        double active, next;
        /* Exact for a factor that is a power of two. */
        if (controller_step_scaled(&state, sway, rate, now[1], noise / head[10], &active) != CONTROLLER_OK) return 2;
        next = fma(1.0 - damping, rate, drive - active);
        noise = noise + slope;
        drive = drive + drive_slope;
        next = fma(head[0] * (head[1] - head[5]), sway, next);
        rate = fma(sway * z, sine, next);
        sway = fma(rate, 0.001, sway);
      }
    }
    noise = next_noise;
  }
  REQUIRE(fclose(out) == 0);
  free(stimulus);
  free(noise_rate);
  return (failures == 0) ? 0 : 1;
}
