/* ---- From samples to the network, row by row ------------------------------------------------------------------------
   waiting for a row, the blocks of all cycles that see the same tilt -> it is drawn -> the lines of the network that
   this makes possible -> waiting for the next row, or done. Values and their order are those of decid's
   dataset/image/series.cpp. */

/* Returns a plane's value for a cycle: from `now` and the values one and two rows before. */
static double shown(int32_t channel, int32_t row, double now, const double before[2]) {
  const double change = now - before[0];
  const double bend = (row < 2) ? 0.0 : (change - (before[0] - before[1]));
  double value = 0.0;
  switch (channel) {
    case CHANNEL_SWAY_CHANGE:
      value = ((row < 1) ? 0.0 : change) / SWAY_CHANGE_KNEE_RAD;
      break;
    case CHANNEL_SWAY_BEND:
      value = bend / SWAY_BEND_KNEE_RAD;
      break;
    case CHANNEL_TORQUE:
      value = ((row < 2) ? 0.0 : (before[0] - (TORQUE_OVER_BEND * bend))) / TORQUE_KNEE_RAD;
      break;
    default:
      value = now / SWAY_KNEE_RAD;
      break;
  }
  return inverse_sinh(value);
}

/* Draws the row that is waited for from state->mean, which it uses up: the mean of the cycles and, from the second on,
   each less the mean of those before. */
static void draw_row(work_state* state, void* arena) {
  activation* const pixels = &maps_of(arena)[network_maps[0].offset];
  const int32_t row = state->window;
  int32_t plane = 0;
  int32_t i;
  int32_t cycle;
#if FOLD > 1
  double sum = state->mean[0];
  for (cycle = 1; cycle < FOLD; ++cycle) {
    const double own = state->mean[cycle];
    state->mean[cycle] = (own - (sum / (double)cycle)) * cycle_scale[cycle];
    sum = sum + own;
  }
  state->mean[0] = sum / (double)FOLD;
#endif
  for (i = 0; i < SERIES_CHANNELS; ++i) {
    if (image_channel[i] > CHANNEL_TORQUE) {
      draw_pixel(pixels, plane, row, 0, (double)given_plane[(given_first[i] * IMAGE_ROWS) + row]);
      ++plane;
    } else {
      for (cycle = 0; cycle < FOLD; ++cycle) {
        draw_pixel(pixels, plane, row, 0, shown(image_channel[i], row, state->mean[cycle], state->before[cycle]));
        ++plane;
      }
    }
  }
  for (cycle = 0; cycle < FOLD; ++cycle) {
    state->before[cycle][1] = state->before[cycle][0];
    state->before[cycle][0] = state->mean[cycle];
  }
  ++state->window;
  state->ready[0] = state->window;
  state->phase = PHASE_NETWORK;
}

static int32_t image_unit(work_state* state, void* arena) {
  if (state->phase != PHASE_DRAW) {
    return 0;
  }
  draw_row(state, arena);
  return 1;
}

static int32_t run_trial(void* arena, const float* sway) {
  work_state* const state = state_of(arena);
  int32_t row;
  int32_t cycle;
  int32_t i;
  start(arena);
  for (row = 0; row < IMAGE_ROWS; ++row) {
    for (cycle = 0; cycle < FOLD; ++cycle) {
      const int32_t first = FIRST_SAMPLE + (cycle * WINDOW) + (row * BLOCK);
      double sum = 0.0;
      for (i = first; i < (first + BLOCK); ++i) {
        const float value = sample_of(sway, i, i);
        if (is_finite_float(value) == 0) {
          return DECID_FW_ERROR_NOT_FINITE;
        }
        sum = sum + (double)value;
      }
      state->mean[cycle] = sum / (double)BLOCK;
    }
    state->phase = PHASE_DRAW;
    finish_work(arena);
  }
  return DECID_FW_OK;
}

/* The network on an image; row scaling applied. */
static int32_t run_image(void* arena, const float* image) {
  int32_t row;
  int32_t channel;
  start(arena);
  for (row = 0; row < IMAGE_ROWS; ++row) {
    for (channel = 0; channel < IMAGE_CHANNELS; ++channel) {
      const float value = image[(channel * IMAGE_ROWS) + row];
      if (is_finite_float(value) == 0) {
        return DECID_FW_ERROR_NOT_FINITE;
      }
      put_pixel(&maps_of(arena)[network_maps[0].offset], channel, row, 0, value);
    }
    state_of(arena)->ready[0] = row + 1;
    state_of(arena)->phase = PHASE_NETWORK;
    finish_work(arena);
  }
  return DECID_FW_OK;
}

#if INCREMENTAL
#if FOLD > 1
static double* kept_means(void* arena, int32_t cycle) {
  return &((double*)(void*)&((unsigned char*)arena)[SAMPLES_OFFSET])[cycle * IMAGE_ROWS];
}
#endif

/* Takes the sample that is number `fed`. */
static int32_t take_sample(void* arena, float value) {
  work_state* const state = state_of(arena);
  const int32_t k = state->fed - FIRST_SAMPLE;
  const int32_t cycle = k / WINDOW;
  const int32_t at = k % WINDOW;
  ++state->fed;
  if ((k >= 0) && (cycle < FOLD) && (at < (IMAGE_ROWS * BLOCK))) {
    state->sum = (((at % BLOCK) == 0) ? 0.0 : state->sum) + (double)value;
    if ((at % BLOCK) == (BLOCK - 1)) {
      const int32_t row = at / BLOCK;
#if FOLD > 1
      int32_t earlier;
      if (cycle < (FOLD - 1)) {
        kept_means(arena, cycle)[row] = state->sum / (double)BLOCK;
        return DECID_FW_OK;
      }
#endif
      finish_work(arena); /* what was left undone of the row before */
#if FOLD > 1
      for (earlier = 0; earlier < (FOLD - 1); ++earlier) {
        state->mean[earlier] = kept_means(arena, earlier)[row];
      }
#endif
      (void)row;
      state->mean[FOLD - 1] = state->sum / (double)BLOCK;
      state->phase = PHASE_DRAW;
    }
  }
  return DECID_FW_OK;
}
#endif
