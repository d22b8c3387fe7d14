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
  activation* pixels;
  int32_t result = check_arena(arena);
  int32_t column;
  int32_t row;
  int32_t channel;
  if ((image == NULL) || (parameters == NULL)) {
    result = DECID_FW_ERROR_NULL;
  }
  if (result != DECID_FW_OK) {
    return (int)result;
  }
  start(arena);
  pixels = &maps_of(arena)[network_maps[0].offset];
  for (column = 0; column < IMAGE_COLUMNS; ++column) {
    for (channel = 0; channel < IMAGE_CHANNELS; ++channel) {
      for (row = 0; row < IMAGE_ROWS; ++row) {
        const float value = image[(((channel * IMAGE_ROWS) + row) * IMAGE_COLUMNS) + column];
        if ((value - value) != 0.0F) {
          return DECID_FW_ERROR_NOT_FINITE;
        }
        put_pixel(pixels, channel, row, column, value);
      }
    }
#if STREAM_ROWS
    if (column < (IMAGE_COLUMNS - 1)) {
      continue;
    }
    state_of(arena)->ready[0] = IMAGE_ROWS;
#else
    state_of(arena)->ready[0] = column + 1;
#endif
    state_of(arena)->phase = PHASE_NETWORK;
    finish_window(arena);
  }
  return (int)take_result(arena, parameters);
}

#if INCREMENTAL
#define MAGIC 0x64656331U /* of an arena that has begun */

static float* samples_of(void* arena) {
  return (float*)(void*)&((unsigned char*)arena)[SAMPLES_OFFSET];
}

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
      if ((sway_rad[i] - sway_rad[i]) != 0.0F) {
        result = DECID_FW_ERROR_NOT_FINITE;
      }
    }
  }
  for (i = 0; (result == DECID_FW_OK) && (i < (int32_t)count); ++i) {
    work_state* const state = state_of(arena);
    const int32_t k = state->fed - FIRST_SAMPLE;
    ++state->fed;
    if ((k >= 0) && (k < (IMAGE_COLUMNS * FOLD * WINDOW))) {
      samples_of(arena)[k % WINDOW] = sway_rad[i];
      if ((k % WINDOW) == (WINDOW - 1)) {
        finish_window(arena); /* what was left undone of the window before */
        result = load_window(arena, samples_of(arena), 0);
      }
    }
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

static uint32_t float_bits(float value) {
  union {
    float value;
    uint32_t bits;
  } u;
  u.value = value;
  return u.bits;
}

int DECID_FW_self_test(void* arena) {
  float parameters[7];
  int32_t i;
  int32_t result = check_arena(arena);
  if (result == DECID_FW_OK) {
    result = run_trial(arena, NULL);
  }
  if (result == DECID_FW_OK) {
    result = take_result(arena, parameters);
  }
  for (i = 0; (i < 7) && (result == DECID_FW_OK); ++i) {
    if ((float_bits(state_of(arena)->outputs[i]) != test_outputs[i]) ||
        (float_bits(parameters[i]) != test_parameters[i])) {
      result = DECID_FW_ERROR_SELF_TEST;
    }
  }
  return (int)result;
}
