/* ---- From windows to the network, unit by unit ----------------------------------------------------------------------
   waiting for a window -> its transform, pass by pass -> its bins kept (of all cycles but the last) or drawn -> the
   lines of the network that this makes possible -> waiting for the next window, or done. */

/* So much is done in one unit of work. */
#define UNIT_POINTS 128
#define UNIT_KEPT_BINS 64
#define UNIT_DRAWN_BINS 8

static complex_value* signal_of(void* arena) {
  return (complex_value*)(void*)&((unsigned char*)arena)[SIGNAL_OFFSET];
}
#if PASSES > 0
static complex_value* scratch_of(void* arena) {
  return (complex_value*)(void*)&((unsigned char*)arena)[SCRATCH_OFFSET];
}
#endif
#if FOLD > 1
static complex_value* spectra_of(void* arena) {
  return (complex_value*)(void*)&((unsigned char*)arena)[SPECTRA_OFFSET];
}
#endif

/* Windows are taken in order of time if they are fed as they arrive, else column by column, which keeps less. */
static int32_t column_of(int32_t window) {
#if INCREMENTAL
  return window % IMAGE_COLUMNS;
#else
  return window / FOLD;
#endif
}
static int32_t cycle_of(int32_t window) {
#if INCREMENTAL
  return window / IMAGE_COLUMNS;
#else
  return window % FOLD;
#endif
}

/* Samples of the window that is waited for; sway NULL: the self-test's. Bad samples change nothing. */
static int32_t load_window(void* arena, const float* sway, int32_t first) {
  work_state* const state = state_of(arena);
  complex_value* const signal = signal_of(arena);
  int32_t n;
  for (n = 0; n < WINDOW; ++n) {
    const float value = sample_of(sway, n, first + n);
    if (is_finite_float(value) == 0) {
      return DECID_FW_ERROR_NOT_FINITE;
    }
#if (WINDOW % 2) == 0
    if ((n % 2) != 0) {
      signal[n / 2].im = (double)value;
    } else {
      signal[n / 2].re = (double)value;
    }
#else
    signal[n].re = (double)value;
    signal[n].im = 0.0;
#endif
  }
  state->pass = 0;
  state->next = 0;
  state->phase = PHASE_TRANSFORM;
  return DECID_FW_OK;
}

static void next_window(work_state* state) {
  state->next = 0;
  ++state->window;
  state->phase = PHASE_WAITING;
}

static void transform_unit(work_state* state, void* arena) {
#if PASSES > 0
  const int32_t radix = pass_radix[state->pass];
  const int32_t all = SIGNAL_LENGTH / radix;
  int32_t left = UNIT_POINTS / radix;
  do {
    run_butterfly(signal_of(arena), state->pass, state->next, scratch_of(arena));
    ++state->next;
    --left;
  } while ((left > 0) && (state->next < all));
  if (state->next == all) {
    state->next = 0;
    ++state->pass;
  }
#else
  (void)arena;
#endif
  if (state->pass == PASSES) {
    state->phase = (cycle_of(state->window) < (FOLD - 1)) ? PHASE_KEEP : PHASE_DRAW;
  }
}

#if FOLD > 1
static complex_value* kept_bins(void* arena, int32_t cycle, int32_t column) {
  return &spectra_of(arena)[((cycle * KEPT_COLUMNS) + (column % KEPT_COLUMNS)) * SHOWN_BINS];
}

static void keep_unit(work_state* state, void* arena) {
  complex_value* const kept = kept_bins(arena, cycle_of(state->window), column_of(state->window));
  int32_t left = UNIT_KEPT_BINS;
  while ((left > 0) && (state->next < SHOWN_BINS)) {
    kept[state->next] = spectrum_bin(signal_of(arena), state->next);
    ++state->next;
    --left;
  }
  if (state->next == SHOWN_BINS) {
    next_window(state);
  }
}
#endif

static void draw_unit(work_state* state, void* arena) {
  const int32_t column = column_of(state->window);
  int32_t left = UNIT_DRAWN_BINS;
  while ((left > 0) && (state->next < SHOWN_BINS)) {
#if FOLD > 1
    const complex_value* const earlier = &kept_bins(arena, 0, column)[state->next];
#else
    const complex_value* const earlier = NULL;
#endif
    draw_bin(&maps_of(arena)[network_maps[0].offset], signal_of(arena), earlier, KEPT_COLUMNS * SHOWN_BINS, state->next,
             column);
    ++state->next;
    --left;
  }
  if (state->next == SHOWN_BINS) {
    next_window(state);
#if STREAM_ROWS
    if (column == (IMAGE_COLUMNS - 1)) {
      state->ready[0] = IMAGE_ROWS;
      state->phase = PHASE_NETWORK;
    }
#else
    state->ready[0] = column + 1;
    state->phase = PHASE_NETWORK;
#endif
  }
}

static int32_t image_unit(work_state* state, void* arena) {
  int32_t worked = 1;
  switch (state->phase) {
    case PHASE_TRANSFORM:
      transform_unit(state, arena);
      break;
#if FOLD > 1
    case PHASE_KEEP:
      keep_unit(state, arena);
      break;
#endif
    case PHASE_DRAW:
      draw_unit(state, arena);
      break;
    default:
      worked = 0;
      break;
  }
  return worked;
}

static int32_t run_trial(void* arena, const float* sway) {
  int32_t result = DECID_FW_OK;
  int32_t window;
  start(arena);
  for (window = 0; (window < (IMAGE_COLUMNS * FOLD)) && (result == DECID_FW_OK); ++window) {
    const int32_t first = FIRST_SAMPLE + (((cycle_of(window) * IMAGE_COLUMNS) + column_of(window)) * WINDOW);
    result = load_window(arena, ((sway == NULL) || (sway == &not_a_number.value)) ? sway : &sway[first], first);
    finish_work(arena);
  }
  return result;
}

/* The network on an image; row scaling applied. */
static int32_t run_image(void* arena, const float* image) {
  activation* pixels;
  int32_t column;
  int32_t row;
  int32_t channel;
  start(arena);
  pixels = &maps_of(arena)[network_maps[0].offset];
  for (column = 0; column < IMAGE_COLUMNS; ++column) {
    for (channel = 0; channel < IMAGE_CHANNELS; ++channel) {
      for (row = 0; row < IMAGE_ROWS; ++row) {
        const float value = image[(((channel * IMAGE_ROWS) + row) * IMAGE_COLUMNS) + column];
        if (is_finite_float(value) == 0) {
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
    finish_work(arena);
  }
  return DECID_FW_OK;
}

#if INCREMENTAL
static float* samples_of(void* arena) {
  return (float*)(void*)&((unsigned char*)arena)[SAMPLES_OFFSET];
}

/* Takes the sample that is number `fed`. */
static int32_t take_sample(void* arena, float value) {
  const int32_t k = state_of(arena)->fed - FIRST_SAMPLE;
  int32_t result = DECID_FW_OK;
  ++state_of(arena)->fed;
  if ((k >= 0) && (k < (IMAGE_COLUMNS * FOLD * WINDOW))) {
    samples_of(arena)[k % WINDOW] = value;
    if ((k % WINDOW) == (WINDOW - 1)) {
      finish_work(arena); /* what was left undone of the window before */
      result = load_window(arena, samples_of(arena), 0);
    }
  }
  return result;
}
#endif
