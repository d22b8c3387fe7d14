
/* Checks gains before DECID_FW_begin() takes them. DECID_FW_OK if this body's loop (linearised, with the step's delay)
   is stable with up to delay_margin_s more delay, and with kp and kd times each factor from 1 / gain_margin to
   gain_margin, also both at once. DECID_FW_DELAY_MARGIN_S and DECID_FW_GAIN_MARGIN_ are of one change each: give a
   gain_margin of 1 or a delay_margin_s of 0 to compare with them.
   parameters NULL: those that this file was made with. delay_margin_s: at least the machine's latency, all of it, and
   what you want to be left, 0 to 1 s. gain_margin: 1 to 100; 1.5 is a start.
   DECID_FW_ERROR_RANGE for parameters that DECID_FW_begin() refuses and for other margins, DECID_FW_ERROR_UNSTABLE for a
   loop that is unstable within them. It refuses a kd and kd_pass of 0, and gains above a million m g h.
   Like the header's margins it takes the passive stiffness and damping to be the body's own. If motors apply
   DECID_FW_passive, that torque is late too: check kp + kp_pass / 2 and kd + kd_pass / 2 with kp_pass and kd_pass 0
   instead (the active torque is 2 (kp a + kd a'), so this is a passive torque as late as the active one).
   It knows neither limits of the torque nor bias nor theta: a large push or a saturated motor may still let the body
   fall. Four square roots and four angles in double, no state: call it outside of the control loop. */
int DECID_FW_check(const DECID_FW_parameters *parameters, double delay_margin_s, double gain_margin);
