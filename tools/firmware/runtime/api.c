/* ---- The functions of the header -----------------------------------------------------------------------------------
 */

int DECID_FW_identify(const float* sway_rad, float* parameters, void* arena) {
  int32_t result = check_arena(arena);
  if ((sway_rad == NULL) || (parameters == NULL)) {
    result = DECID_FW_ERROR_NULL;
  }
  if (result == DECID_FW_OK) {
    result = run_trial(arena, sway_rad);
  }
  if (result == DECID_FW_OK) {
    result = take_result(arena, parameters);
  }
  return (int)result;
}

int DECID_FW_identify_image(const float* image, float* parameters, void* arena) {
  int32_t result = check_arena(arena);
  if ((image == NULL) || (parameters == NULL)) {
    result = DECID_FW_ERROR_NULL;
  }
  if (result == DECID_FW_OK) {
    result = run_image(arena, image);
  }
  if (result == DECID_FW_OK) {
    result = take_result(arena, parameters);
  }
  return (int)result;
}

#if COMPONENTS > 0
int DECID_FW_stddevs(float* stddevs, void* arena) {
  int32_t result = check_arena(arena);
  if (stddevs == NULL) {
    result = DECID_FW_ERROR_NULL;
  }
  if (result == DECID_FW_OK) {
    result = take_stddevs(arena, stddevs);
  }
  return (int)result;
}
#endif

#if INCREMENTAL
#define MAGIC 0x64656331U /* of an arena that has begun */

static int32_t check_begun(void* arena) {
  int32_t result = check_arena(arena);
  if ((result == DECID_FW_OK) && (state_of(arena)->magic != MAGIC)) {
    result = DECID_FW_ERROR_STATE;
  }
  return result;
}

int DECID_FW_begin(void* arena) {
  const int32_t result = check_arena(arena);
  if (result == DECID_FW_OK) {
    start(arena);
    state_of(arena)->magic = MAGIC;
  }
  return (int)result;
}

int DECID_FW_feed(const float* sway_rad, int count, void* arena) {
  int32_t result = check_begun(arena);
  int32_t i;
  if (sway_rad == NULL) {
    result = DECID_FW_ERROR_NULL;
  }
  if (result == DECID_FW_OK) {
    const int32_t room = DECID_FW_SAMPLES - state_of(arena)->fed;
    if ((count < 0) || (count > (int)room)) {
      result = DECID_FW_ERROR_COUNT;
    }
    for (i = 0; (result == DECID_FW_OK) && (i < (int32_t)count); ++i) {
      if (is_finite_float(sway_rad[i]) == 0) {
        result = DECID_FW_ERROR_NOT_FINITE;
      }
    }
  }
  for (i = 0; (result == DECID_FW_OK) && (i < (int32_t)count); ++i) {
    result = take_sample(arena, sway_rad[i]);
  }
  return (int)result;
}

int DECID_FW_work(void* arena) {
  int32_t result = check_begun(arena);
  if (result == DECID_FW_OK) {
    result = (work_unit(arena) != 0) ? DECID_FW_MORE : DECID_FW_OK;
  }
  return (int)result;
}

int DECID_FW_result(float* parameters, void* arena) {
  int32_t result = check_begun(arena);
  if (parameters == NULL) {
    result = DECID_FW_ERROR_NULL;
  }
  if (result == DECID_FW_OK) {
    result = take_result(arena, parameters);
  }
  return (int)result;
}
#endif

int DECID_FW_self_test(void* arena) {
  float parameters[PARAMETERS];
  int32_t i;
  int32_t result = check_arena(arena);
  const int32_t can_use = (result == DECID_FW_OK) ? 1 : 0;
  if ((result == DECID_FW_OK) && (keeps_subnormals() == 0)) {
    result = DECID_FW_ERROR_SELF_TEST;
  }
  if ((result == DECID_FW_OK) && (run_trial(arena, &not_a_number.value) != DECID_FW_ERROR_NOT_FINITE)) {
    result = DECID_FW_ERROR_SELF_TEST;
  }
  if (result == DECID_FW_OK) {
    result = run_trial(arena, NULL);
  }
  if (result == DECID_FW_OK) {
    result = take_result(arena, parameters);
  }
  for (i = 0; (i < OUTPUTS) && (result == DECID_FW_OK); ++i) {
    if (float_bits(state_of(arena)->outputs[i]) != test_outputs[i]) {
      result = DECID_FW_ERROR_SELF_TEST;
    }
  }
  for (i = 0; (i < PARAMETERS) && (result == DECID_FW_OK); ++i) {
    if (float_bits(parameters[i]) != test_parameters[i]) {
      result = DECID_FW_ERROR_SELF_TEST;
    }
  }
#if COMPONENTS > 0
  if (result == DECID_FW_OK) {
    result = take_stddevs(arena, parameters);
  }
  for (i = 0; (i < PARAMETERS) && (result == DECID_FW_OK); ++i) {
    if (float_bits(parameters[i]) != test_stddevs[i]) {
      result = DECID_FW_ERROR_SELF_TEST;
    }
  }
#endif
#if FAMILIARITY
  if (result == DECID_FW_OK) {
    double distance = 0.0;
    result = take_distance(arena, &distance);
    if ((result == DECID_FW_OK) && !(distance == TEST_DISTANCE)) {
      result = DECID_FW_ERROR_SELF_TEST;
    }
  }
#endif
  if (can_use != 0) {
    start(arena); /* no result of the self-test's sway stays */
  }
  return (int)result;
}
