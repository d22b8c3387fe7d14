
/* How far the trial of the last result in the arena is from those that the model was trained on, by the network's
   features: below 1 are 97 of 100 simulated trials. decid identify also looks whether the sway follows the tilt, for
   which it simulates: above DECID_FW_DISTANCE_NOT_USABLE it says "not usable" in any case, up to
   DECID_FW_DISTANCE_USABLE never for that reason. Needs the arena as that call left it; DECID_FW_ERROR_STATE if there
   is no result. All in one call, in double: two additions and a multiplication for each of DECID_FW_DISTANCE_BYTES / 4
   numbers. */
int DECID_FW_distance(double* distance, void* arena);
