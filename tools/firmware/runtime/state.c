/* ---- State of an identification ----------------------------------------------------------------------------- */

/* Spectra: waiting -> transform -> keep or draw -> network -> waiting, or done. Series: waiting -> draw -> network ...
 */
enum { PHASE_WAITING = 1, PHASE_TRANSFORM, PHASE_KEEP, PHASE_DRAW, PHASE_NETWORK, PHASE_DONE };

typedef struct {
  uint32_t magic;
  int32_t phase;
  int32_t window; /* that is worked on, or waited for; of series, the row */
  int32_t pass;
  int32_t next; /* butterfly, bin */
  int32_t fed;  /* samples */
  int32_t ready[MAPS];
  float outputs[OUTPUTS];
#if SERIES
  double sum;             /* of the block that is fed */
  double mean[FOLD];      /* of the row that is drawn, cycle by cycle */
  double before[FOLD][2]; /* what one and two rows before it are, see draw_row */
#endif
} work_state;

/* The arena is at least as large as this; sizes are checked where the tables are made and here. */
typedef char arena_holds_the_state[(sizeof(work_state) <= (size_t)STATE_BYTES) ? 1 : -1];

static work_state* state_of(void* arena) {
  return (work_state*)arena;
}
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

/* A trial that the self-test feeds, all of it NaN: its address stands for it, and no other sample is read there. */
static const union {
  uint32_t bits;
  float value;
} not_a_number = {0x7fc00000U};

/* Sample `own` of `sway`, which is number k of the trial; sway NULL: the self-test's. */
static float sample_of(const float* sway, int32_t own, int32_t k) {
  float value;
  if (sway == NULL) {
    value = self_test_value(k);
  } else if (sway == &not_a_number.value) {
    value = sway[0];
  } else {
    value = sway[own];
  }
  return value;
}

/* One unit of what makes the image; 0 if there is none that can be done now. */
static int32_t image_unit(work_state* state, void* arena);

/* One unit of work; 0 if there is none that can be done now. */
static int32_t work_unit(void* arena) {
  work_state* const state = state_of(arena);
  int32_t worked;
  if (state->phase != PHASE_NETWORK) {
    return image_unit(state, arena);
  }
  worked = advance_network(state->ready, maps_of(arena), patch_of(arena), state->outputs);
  if (state->ready[MAPS - 1] > 0) {
    state->phase = PHASE_DONE;
  } else if (worked == 0) {
    state->phase = PHASE_WAITING;
  } else {
    /* more to come */
  }
  return worked;
}

static void finish_work(void* arena) {
  while (work_unit(arena) != 0) {
    /* on */
  }
}
