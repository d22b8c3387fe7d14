
/* How sure the last result in the arena is: the standard deviation of each parameter, in its unit. Needs the arena as
   that call left it; DECID_FW_ERROR_STATE if there is no result, and
   DECID_FW_ERROR_NOT_FINITE if one is infinite or NaN. All in one call, in double:
   some tens of thousands of multiplications for each Gaussian of the mixture. */
int DECID_FW_stddevs(float* stddevs, void* arena);
