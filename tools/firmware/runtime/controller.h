#ifndef DECID_FW_H
#define DECID_FW_H

#ifdef __cplusplus
extern "C" {
#endif

@CONSTANTS@
/* Return codes. */
enum {
  DECID_FW_OK = 0,
  DECID_FW_ERROR_NULL = -1,       /* a pointer is null */
  DECID_FW_ERROR_RANGE = -2,      /* a parameter is negative or no number, or the delay is longer than the line */
  DECID_FW_ERROR_SELF_TEST = -3,  /* NaN was not refused, or other bits than the program that made this file computed */
  DECID_FW_ERROR_NOT_FINITE = -4, /* an input of a step is infinite or NaN, or so large that its torque would be */
  DECID_FW_ERROR_STATE = -5       /* the state was never begun */
};

/* The identified parameters, in SI units. */
typedef struct {
  double kp;      /* N m/rad */
  double kd;      /* N m s/rad */
  double kp_pass; /* N m/rad, the ankle's own stiffness: DECID_FW_passive */
  double kd_pass; /* N m s/rad */
  double theta;   /* rad/s */
  double delay;   /* s, from the sway to its torque: less the latency of your sensors, actuators and bus */
@GAINS@} DECID_FW_parameters;

/* A controller: parameters in the units of a step, and its state. Content is private. */
typedef struct {
  double kp, kd, passive, damping, theta, fraction;
  double error, newer;
@STATE@  int whole, first_step, step, begun;
  double commands[DECID_FW_DELAY_STEPS];
} DECID_FW_state;

/* The parameters that this file was made with. */
extern const DECID_FW_parameters DECID_FW_identified;

/* At rest, upright. parameters NULL: those that this file was made with. On an error the state does not change.
   It empties the delay line: the torque is 0 for one delay. Call it only while the machine stands safely, or begin a
   second state, give it the same steps for one delay, and then use its torque. A model's result may lie a little
   outside of its range, also below 0, which is DECID_FW_ERROR_RANGE here: limit it first. */
int DECID_FW_begin(DECID_FW_state *state, const DECID_FW_parameters *parameters);

/* One step: call it exactly every DECID_FW_STEP_S seconds, because the step is fixed. torque: the active torque on the
   body in N m, positive towards positive sway.
   sway_rad, sway_rate: the body's centre of mass in space, rad and rad/s.
   support_rate: the tilt rate of what it stands on, in space, rad/s. It must have no bias: the controller integrates it
   where it is below theta, so a bias makes the body lean ever further. Do not subtract the ankle's rate from a gyro's.
   Subtract the encoder's ankle angle from the inertial sensor's angle of the body, and differentiate the difference.
   vestibular_rate: the error with which the support's rate is sensed, rad/s: vestibular noise, or a gyro's error (the
   rate by the gyro less support_rate). The threshold theta hides it, so a bias does no harm here. 0: none.
   A state without DECID_FW_begin() (all zeros, for example) gives DECID_FW_ERROR_STATE. On an error, state and torque
   do not change: call it again with the next sample that is a number. You decide what the ankle does meanwhile. */
int DECID_FW_step(DECID_FW_state *state, double sway_rad, double sway_rate, double support_rate, double vestibular_rate,
                  double *torque);
/* The same before its scaling to N m, the number that the simulator computes with: minus the torque times
   DECID_FW_STEP_S over DECID_FW_INERTIA_KGM2, rad/s. */
int DECID_FW_step_scaled(DECID_FW_state *state, double sway_rad, double sway_rate, double support_rate,
                         double vestibular_rate, double *scaled);

/* The passive torque, for a machine whose ankle has no stiffness of its own. ankle_rad: body less support.
   Returns NaN for inputs that are infinite or NaN, or so large that the torque would be, and for a state without
   DECID_FW_begin(). */
double DECID_FW_passive(const DECID_FW_state *state, double ankle_rad, double ankle_rate);

/* Begins the state, feeds it NaN, then lets the controller balance a simulated body on the protocol's tilt for DECID_FW_TEST_STEPS steps and compares the
   bits of its sway with decid's. */
int DECID_FW_self_test(DECID_FW_state *state);

#ifdef __cplusplus
}
#endif

#endif
