#ifndef DECID_FW_H
#define DECID_FW_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

@CONSTANTS@
/* How far this body, with the parameters that the file was made with, is from falling (linearised; 0, 1 and 1 for an
   unstable loop). DELAY_MARGIN_S: what sensors, bus and motors may add to this file's delay, at most 1. All of their
   latency counts, also what was subtracted from the delay for it. GAIN_MARGIN: the factors between which kp and kd
   together keep it stable, at most 100. Keep away from these limits: near them each push swings for long.
   They hold for a body with passive stiffness and damping of its own. If motors apply DECID_FW_passive, its latency is
   not in DELAY_MARGIN_S, and a wrong torque constant scales it too@PASSIVE_LIMIT@.
   PEAK_TORQUE_NM: the largest active torque in the protocol's trial, without a push.
   Other gains at run time have other margins: @OTHER_GAINS@ */
@LIMITS@
/* Return codes. */
enum {
  DECID_FW_OK = 0,
  DECID_FW_ERROR_NULL = -1,       /* a pointer is null */
  DECID_FW_ERROR_RANGE = -2,      /* a parameter is negative or no number, or the delay is longer than the line */
  DECID_FW_ERROR_SELF_TEST = -3,  /* NaN was not refused, subnormal numbers were flushed to 0, or other bits than the
                                     program that made this file computed */
  DECID_FW_ERROR_NOT_FINITE = -4, /* an input of a step is infinite or NaN, or so large that its torque would be */
  DECID_FW_ERROR_STATE = -5,      /* the state was never begun, or was in the self-test */
  DECID_FW_ERROR_UNSTABLE = -6    /* of a check of gains: the loop is unstable within the margins */
};

/* The identified parameters, in SI units. */
typedef struct {
  double kp;      /* N m/rad */
  double kd;      /* N m s/rad */
  double kp_pass; /* N m/rad, the ankle's own stiffness: DECID_FW_passive */
  double kd_pass; /* N m s/rad */
  double theta;   /* rad/s */
  double delay;   /* s, from the sway to its torque, of the whole loop: an estimate contains the latency of the machine's
                     own sensors, actuators and bus: subtract it */
@GAINS@} DECID_FW_parameters;

/* A controller: parameters in the units of a step, and its state. Content is private. A call must not interrupt another
   one with the same state, as a timer's interrupt does that steps while the main loop begins the state. Calls with
   different states are independent. */
typedef struct {
  double kp, kd, passive, damping, theta, fraction;
  double error, newer;
@STATE@  int32_t whole, first_step, step, begun;
  double commands[DECID_FW_DELAY_STEPS];
} DECID_FW_state;

/* The parameters that this file was made with. */
extern const DECID_FW_parameters DECID_FW_identified;

/* At rest, upright. parameters NULL: those that this file was made with. On an error the state does not change.
   It empties the delay line: the torque is 0 for one delay. Call it only while the machine stands safely. A second state
   can take over without this pause: begin it, give both states the same steps for one delay, then use the second one's
   torque. This torque jumps, because its tilt error and slow feedback began at 0. So copy the tilt error
   (DECID_FW_set_tilt_error) before the first of these steps. If the controller has slow or torque feedback, also go from
   one torque to the other little by little, over several seconds.
   Begin again after every time that the torque was limited or not applied (a limit, a fall, a machine that was held): the
   controller does not know of it. Slow and torque feedback would have wound up, after which the body may fall.
   A model's result may lie a little outside of its range, also below 0, which is DECID_FW_ERROR_RANGE here: limit it
   first. */
int DECID_FW_begin(DECID_FW_state *state, const DECID_FW_parameters *parameters);
@CHECK@
/* One step: call it exactly every DECID_FW_STEP_S seconds, because the step is fixed. torque: the active torque on the
   body in N m, positive towards positive sway.
   sway_rad, sway_rate: the body's centre of mass in space, rad and rad/s.
   support_rate: the tilt rate of what it stands on, in space, rad/s. Positive turns the same way as positive sway. The
   controller integrates it where it is below theta. So it must have no bias, which makes the body lean ever further, and
   motion that is faster than theta one way and slower the other counts like a bias: DECID_FW_tilt_error. Do not subtract
   the ankle's rate from a gyro's. Subtract the encoder's ankle angle from the inertial sensor's angle of the body, and
   differentiate the difference.
   vestibular_rate: the error with which the support's rate is sensed, rad/s: simulated vestibular noise. Give 0 for a
   machine. theta hides an error only while the support is still and the error stays below theta. A larger bias, or any
   bias while the support moves, leans the body without limit (theta 0.0026, bias 0.005 rad/s: 15 degrees after 143 s).
   So remove a gyro's bias first.
   A state without DECID_FW_begin() (all zeros, for example) gives DECID_FW_ERROR_STATE. On an error, state and torque
   do not change. The delay counts calls, so a step that is left out makes it longer. For a sample that is lost or no
   number, and for each tick that was missed, call it with the last good inputs. You decide what the ankle does
   meanwhile. A finite outlier (a rate over a wrapped angle, a word misread from a bus) is an input like any other: its
   torque comes one delay later. Compare each input with its sensor's range, and treat an outlier as a lost sample. */
int DECID_FW_step(DECID_FW_state *state, double sway_rad, double sway_rate, double support_rate, double vestibular_rate,
                  double *torque);
/* The same before its scaling to N m, the number that the simulator computes with: minus the torque times
   DECID_FW_STEP_S over DECID_FW_INERTIA_KGM2, rad/s. */
int DECID_FW_step_scaled(DECID_FW_state *state, double sway_rad, double sway_rate, double support_rate,
                         double vestibular_rate, double *scaled);

/* How wrong the controller takes the support's tilt to be, rad: the tilt as estimated less the tilt, positive as sway
   is. The body leans the other way. The error grows with what theta hides of the support's motion: 2 degrees up at 5
   degrees/s and back at 0.05 leave 1.5 degrees of lean.@TILT_ERROR@
   NaN for a state without DECID_FW_begin(). */
double DECID_FW_tilt_error(const DECID_FW_state *state);

/* Sets the tilt error, rad, and leaves the delay line as it is. @REZERO@
   The torque changes by kp times the change, one delay later, so go there in small steps.
   DECID_FW_ERROR_NOT_FINITE for an error that is infinite or NaN, DECID_FW_ERROR_STATE for a state without
   DECID_FW_begin(): the state does not change. */
int DECID_FW_set_tilt_error(DECID_FW_state *state, double tilt_error_rad);

/* The passive torque, for a machine whose ankle has no stiffness of its own. ankle_rad: body less support, positive as
   sway is.
   Returns NaN for inputs that are infinite or NaN, or so large that the torque would be, and for a state without
   DECID_FW_begin(). */
double DECID_FW_passive(const DECID_FW_state *state, double ankle_rad, double ankle_rate);

/* Begins the state, feeds it NaN, then lets the controller balance a simulated body on the protocol's tilt for
   DECID_FW_TEST_STEPS steps and compares the bits of its sway with decid's.@TEST_OF_CHECK@ Afterwards the state has not begun: call
   DECID_FW_begin(). */
int DECID_FW_self_test(DECID_FW_state *state);

#ifdef __cplusplus
}
#endif

#endif
