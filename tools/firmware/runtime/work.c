/* ---- The work, unit by unit -----------------------------------------------------------------------------------------
   waiting for a window -> its transform, pass by pass -> its bins kept (of all cycles but the last) or drawn -> the
   lines of the network that this makes possible -> waiting for the next window, or done. */

enum { PHASE_WAITING = 1, PHASE_TRANSFORM, PHASE_KEEP, PHASE_DRAW, PHASE_NETWORK, PHASE_DONE };

/* So much is done in one unit of work. */
#define UNIT_POINTS 128
#define UNIT_KEPT_BINS 64
#define UNIT_DRAWN_BINS 8

typedef struct {
  uint32_t magic;
  int32_t phase;
  int32_t window; /* that is worked on, or waited for */
  int32_t pass;
  int32_t next; /* butterfly, bin */
  int32_t fed;  /* samples */
  int32_t ready[MAPS];
  float outputs[7];
} work_state;

/* The arena is at least as large as this; sizes are checked where the tables are made and here. */
typedef char arena_holds_the_state[(sizeof(work_state) <= (size_t)STATE_BYTES) ? 1 : -1];

static work_state* state_of(void* arena) {
  return (work_state*)arena;
}
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
static activation* maps_of(void* arena) {
  return (activation*)(void*)&((unsigned char*)arena)[MAPS_OFFSET];
}
static activation* patch_of(void* arena) {
  return (activation*)(void*)&((unsigned char*)arena)[PATCH_OFFSET];
}

static int32_t check_arena(const void* arena) {
  int32_t result = DECID_FW_OK;
  if (arena == NULL) {
    result = DECID_FW_ERROR_NULL;
  } else if (((uintptr_t)arena % 8U) != 0U) {
    result = DECID_FW_ERROR_ALIGNMENT;
  } else {
    /* can be used */
  }
  return result;
}

static void start(void* arena) {
  work_state* const state = state_of(arena);
  int32_t i;
  state->magic = 0U; /* samples are taken only after begin */
  state->phase = PHASE_WAITING;
  state->window = 0;
  state->pass = 0;
  state->next = 0;
  state->fed = 0;
  for (i = 0; i < MAPS; ++i) {
    state->ready[i] = 0;
  }
}

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

/* A sway for the self-test: a slow triangle with noise on it, in exact arithmetic. */
static float test_sample(int32_t k) {
  uint32_t x = (uint32_t)k * 2654435761U;
  const int32_t ramp = (k % 2420) - 1210;
  const int32_t triangle = 605 - ((ramp < 0) ? -ramp : ramp);
  x ^= x >> 15;
  x *= 2246822519U;
  x ^= x >> 13;
  return ((float)triangle * 1.52587890625e-05F) + ((float)((int32_t)(x >> 8) - 8388608) * 1.1641532182693481e-10F);
}

/* Samples of the window that is waited for; sway NULL: the self-test's. Bad samples change nothing. */
static int32_t load_window(void* arena, const float* sway, int32_t first) {
  work_state* const state = state_of(arena);
  complex_value* const signal = signal_of(arena);
  int32_t n;
  for (n = 0; n < WINDOW; ++n) {
    const float value = (sway == NULL) ? test_sample(first + n) : sway[n];
    if ((value - value) != 0.0F) { /* true of infinities and NaN */
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

/* One unit of work; 0 if there is none that can be done now. */
static int32_t work_unit(void* arena) {
  work_state* const state = state_of(arena);
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
    case PHASE_NETWORK:
      worked = advance_network(state->ready, maps_of(arena), patch_of(arena), state->outputs);
      if (state->ready[MAPS - 1] > 0) {
        state->phase = PHASE_DONE;
      } else if (worked == 0) {
        state->phase = PHASE_WAITING;
      } else {
        /* more to come */
      }
      break;
    default:
      worked = 0;
      break;
  }
  return worked;
}

static void finish_window(void* arena) {
  while (work_unit(arena) != 0) {
    /* on */
  }
}

static int32_t take_result(void* arena, float* parameters) {
  const work_state* const state = state_of(arena);
  int32_t i;
  if (state->phase != PHASE_DONE) {
    return DECID_FW_ERROR_STATE;
  }
  for (i = 0; i < 7; ++i) {
    parameters[i] = (float)(target_mean[i] + ((double)state->outputs[i] * target_deviation[i]));
  }
  return DECID_FW_OK;
}

static int32_t run_trial(void* arena, const float* sway) {
  int32_t result = DECID_FW_OK;
  int32_t window;
  start(arena);
  for (window = 0; (window < (IMAGE_COLUMNS * FOLD)) && (result == DECID_FW_OK); ++window) {
    const int32_t first = FIRST_SAMPLE + (((cycle_of(window) * IMAGE_COLUMNS) + column_of(window)) * WINDOW);
    result = load_window(arena, (sway == NULL) ? NULL : &sway[first], first);
    finish_window(arena);
  }
  return result;
}
