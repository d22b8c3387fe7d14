/* ---- The functions of the header -----------------------------------------------------------------------------------
 */

static activation* maps_of(void* arena) {
  return (activation*)(void*)&((unsigned char*)arena)[MAPS_OFFSET];
}
static activation* patch_of(void* arena) {
  return (activation*)(void*)&((unsigned char*)arena)[PATCH_OFFSET];
}

static float* outputs_of(void* arena) {
  return (float*)(void*)&((unsigned char*)arena)[OUTPUTS_OFFSET];
}

/* Leaves the outputs in the arena. input NULL: the self-test's. */
static int32_t run_network(const float* input, void* arena) {
  int32_t* const ready = (int32_t*)arena;
  int32_t i;
  if (arena == NULL) {
    return DECID_FW_ERROR_NULL;
  }
  if (((uintptr_t)arena % 8U) != 0U) {
    return DECID_FW_ERROR_ALIGNMENT;
  }
  for (i = 0; i < INPUTS; ++i) {
    const float value = (input == NULL) ? self_test_value(i) : input[i];
    if (is_finite_float(value) == 0) {
      return DECID_FW_ERROR_NOT_FINITE;
    }
    maps_of(arena)[i] = value;
  }
  for (i = 0; i < MAPS; ++i) {
    ready[i] = 0;
  }
  ready[0] = network_maps[0].lines;
  while (advance_network(ready, maps_of(arena), patch_of(arena), outputs_of(arena)) != 0) {
    /* on */
  }
  for (i = 0; i < OUTPUTS; ++i) {
    if (is_finite_float(outputs_of(arena)[i]) == 0) {
      return DECID_FW_ERROR_NOT_FINITE;
    }
  }
  return DECID_FW_OK;
}

int DECID_FW_run(const float* input, float* outputs, void* arena) {
  int32_t result = DECID_FW_ERROR_NULL;
  int32_t i;
  if ((input != NULL) && (outputs != NULL)) {
    result = run_network(input, arena);
  }
  for (i = 0; (i < OUTPUTS) && (result == DECID_FW_OK); ++i) {
    outputs[i] = outputs_of(arena)[i];
  }
  return (int)result;
}

int DECID_FW_self_test(void* arena) {
  int32_t i;
  int32_t result = run_network(NULL, arena);
  if ((result == DECID_FW_OK) && (keeps_subnormals() == 0)) {
    result = DECID_FW_ERROR_SELF_TEST;
  }
  for (i = 0; (i < OUTPUTS) && (result == DECID_FW_OK); ++i) {
    if (float_bits(outputs_of(arena)[i]) != test_outputs[i]) {
      result = DECID_FW_ERROR_SELF_TEST;
    }
  }
  return (int)result;
}
