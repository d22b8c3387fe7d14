/* Identifies the trials of sway.bin (float32, rad) twice, as a whole and as samples arrive, writes the parameters to
   results.bin, lets the controller run with them, and prints what it all cost. A product reads its sensor where this
   reads a file, and drives its ankle where this drops the torque. */
#include "balance.h"
#include "posture.h"
#include "semihosting.h"
#include "verdict.h"

#define FEED_SAMPLES 110 /* 1.1 s */
#define UNITS_A_FEED 8
#define TIMED_STEPS 10000
#define CHECKED_SETS 400

/* SysTick counts the board's 25 MHz, or 32; QEMU with -icount shift=0 gives every instruction 1 ns: 40 of them a tick,
   or 31.25. */
#define SYSTICK ((volatile uint32_t*)0xe000e010U)
#ifdef BOARD_32_MHZ
#define INSTRUCTIONS_OF(ticks) (((ticks)*125U) / 4U)
#else
#define INSTRUCTIONS_OF(ticks) ((ticks)*40U)
#endif
#define STACK_PATTERN 0x5a5a5a5aU

extern uint32_t stack_low[], stack_top[];

static posture_arena arena;
static float sway[POSTURE_SAMPLES];
static balance_state controller;
static uint32_t last_tick;

static void print_number(const char* before, uint32_t value, const char* after) {
  char digits[12];
  uint32_t rest = value;
  int32_t i = 11;
  digits[i] = '\0';
  do {
    --i;
    digits[i] = (char)('0' + (char)(rest % 10U));
    rest /= 10U;
  } while (rest > 0U);
  host_print(before);
  host_print(&digits[i]);
  host_print(after);
}

static void start_counting(void) {
  SYSTICK[1] = 0x00ffffffU;
  SYSTICK[2] = 0U;
  SYSTICK[0] = 5U;
  last_tick = SYSTICK[2];
}

/* Instructions since the last call, to 40; up to 524 million. */
static uint32_t instructions(void) {
  const uint32_t now = SYSTICK[2];
  const uint32_t ticks = (last_tick - now) & 0x00ffffffU;
  last_tick = now;
  return INSTRUCTIONS_OF(ticks);
}

static void paint_stack(void) {
  uint32_t* here;
  uint32_t* p;
  __asm__ volatile("mov %0, sp" : "=r"(here));
  for (p = stack_low; p < (here - 16); ++p) {
    *p = STACK_PATTERN;
  }
}

static uint32_t stack_used(void) {
  const uint32_t* p = stack_low;
  while (*p == STACK_PATTERN) {
    ++p;
  }
  return (uint32_t)(stack_top - p) * 4U;
}

/* The counter itself: a loop of 200,000 instructions. */
static void check_counter(void) {
  uint32_t count = 100000U;
  (void)instructions();
  __asm__ volatile("1: subs %0, %0, #1\n\tbne 1b" : "+r"(count) : : "cc");
  print_number("counter_check ", instructions(), "\n");
}

typedef struct {
  uint32_t all, max_unit, after_last_sample;
} cost;

static uint32_t larger(uint32_t a, uint32_t b) {
  return (a > b) ? a : b;
}

static int identify_as_samples_arrive(float* parameters, cost* spent) {
  int32_t fed;
  int32_t unit;
  int result = posture_begin(&arena);
  spent->all = 0U;
  spent->max_unit = 0U;
  (void)instructions();
  for (fed = 0; (fed < POSTURE_SAMPLES) && (result >= 0); fed += FEED_SAMPLES) {
    const int32_t left = POSTURE_SAMPLES - fed;
    uint32_t here;
    result = posture_feed(&sway[fed], (left < FEED_SAMPLES) ? (int)left : FEED_SAMPLES, &arena);
    here = instructions();
    spent->all += here;
    spent->max_unit = larger(spent->max_unit, here);
    for (unit = 0; (unit < UNITS_A_FEED) && (result >= 0); ++unit) {
      result = posture_work(&arena);
      here = instructions();
      spent->all += here;
      spent->max_unit = larger(spent->max_unit, here);
      if (result != POSTURE_MORE) {
        break;
      }
    }
  }
  spent->after_last_sample = 0U;
  while (result == POSTURE_MORE) {
    uint32_t here;
    result = posture_work(&arena);
    here = instructions();
    spent->after_last_sample += here;
    spent->max_unit = larger(spent->max_unit, here);
  }
  spent->all += spent->after_last_sample;
  return (result >= 0) ? posture_result(parameters, &arena) : result;
}

/* A network may answer a little outside of a parameter's range, also below 0, which balance_begin refuses. */
static double limited(const float* identified, int32_t parameter) {
  static const float low[POSTURE_PARAMETERS] = POSTURE_MINIMA;
  static const float high[POSTURE_PARAMETERS] = POSTURE_MAXIMA;
  const float value = identified[parameter];
  const float at_least = (value > low[parameter]) ? value : low[parameter];
  return (double)((at_least < high[parameter]) ? at_least : high[parameter]);
}

static int is_near(double x, double y) {
  return ((x >= (0.999 * y)) && (x <= (1.001 * y))) ? 1 : 0;
}

/* Returns 1 if the model answers for the controller's body: gains of one body are not another one's. */
static int is_one_body(void) {
  return ((is_near(POSTURE_MASS_KG, BALANCE_MASS_KG) != 0) &&
          (is_near(POSTURE_COM_HEIGHT_M, BALANCE_COM_HEIGHT_M) != 0) &&
          (is_near(POSTURE_INERTIA_KGM2, BALANCE_INERTIA_KGM2) != 0))
             ? 1
             : 0;
}

/* The cost of a step, on average over a machine's ordinary inputs and the worst one measured. Software arithmetic takes
   longer for some numbers than for others, and least for 0: no input is the same twice, and two more passes have many
   sizes, either sign, a vestibular rate and a support faster than theta. The last one has subnormal numbers only. */
static int tell_steps(const balance_parameters* parameters) {
  static const double sizes[2][8] = {{1.0, 1e-307, 0.1, 1e-3, 1e-9, 1e-300, 10.0, 1e3},
                                     {1e-306, 1e-307, 1e-308, 1e-309, 1e-310, 1e-311, 1e-312, 1e-313}};
  uint32_t all = 0U;
  uint32_t worst = 0U;
  int32_t step;
  int result = BALANCE_OK;
  for (step = 0; (step < (3 * TIMED_STEPS)) && (result == BALANCE_OK); ++step) {
    /* volatile: computed before the count begins */
    volatile double sway_rad = 0.001 + (1e-6 * (double)((step * 37) % 101));
    volatile double rate = 0.002 + (1e-5 * (double)((step * 61) % 103));
    volatile double support_rate = 1e-5 * (double)(((step * 17) % 107) - 53);
    volatile double vestibular_rate = 0.0;
    double torque = 0.0;
    uint32_t here;
    if (step >= TIMED_STEPS) {
      const double* const size = sizes[(step / TIMED_STEPS) - 1];
      sway_rad = size[(step / 13) % 8] * 200.0 * (sway_rad - 0.00105);
      rate = size[(step / 29) % 8] * 100.0 * (rate - 0.0025);
      support_rate = size[(step / 7) % 8] * 10.0 * support_rate;
      vestibular_rate = size[(step / 17) % 8] * 1e-4 * (double)(((step * 23) % 109) - 54);
    }
    if ((step % TIMED_STEPS) == 0) {
      result = balance_begin(&controller, parameters);
    }
    if (result == BALANCE_OK) {
      (void)instructions();
      result = balance_step(&controller, sway_rad, rate, support_rate, vestibular_rate, &torque);
      here = instructions();
      all += (step < TIMED_STEPS) ? here : 0U;
      worst = larger(worst, here);
    }
  }
  print_number("controller_instructions_a_step ", all / (uint32_t)TIMED_STEPS, "\n");
  print_number("controller_instructions_worst_step ", worst, "\n");
  return result;
}

static double next_random(uint32_t* seed) {
  *seed = (*seed * 1664525U) + 1013904223U;
  return (double)(*seed >> 8) / 16777216.0;
}

/* The worst cost of a check that was measured, over random gains and margins. */
static void tell_checks(void) {
  static balance_parameters asked;
  uint32_t worst = 0U;
  uint32_t seed = 1U;
  int32_t set;
  asked = balance_identified;
  for (set = 0; set < CHECKED_SETS; ++set) {
    volatile double delay_margin_s = 0.05 * next_random(&seed);
    volatile double gain_margin = 1.0 + next_random(&seed);
    asked.kp = BALANCE_MGH_NM_RAD * (0.5 + (1.5 * next_random(&seed)));
    asked.kd = BALANCE_MGH_NM_RAD * (0.6 * next_random(&seed));
    asked.kp_pass = BALANCE_MGH_NM_RAD * (0.5 * next_random(&seed));
    asked.kd_pass = BALANCE_MGH_NM_RAD * (0.2 * next_random(&seed));
    asked.delay = 0.15 * next_random(&seed);
    __asm__ volatile("" : : "r"(&asked) : "memory"); /* computed before the count begins */
    (void)instructions();
    (void)balance_check(&asked, delay_margin_s, gain_margin);
    worst = larger(worst, instructions());
  }
  print_number("controller_instructions_check ", worst, "\n");
}

/* The controller's own test, then steps with the parameters that were identified, if they are usable. */
static int run_controller(const float* identified, verdict usable) {
  balance_parameters parameters;
  double largest = 0.0;
  int32_t step;
  int result;
  paint_stack(); /* once: the figure is the largest of all the controller's calls */
  (void)instructions();
  result = balance_self_test(&controller);
  print_number("controller_instructions_self_test ", instructions(), "\n");
  print_number("controller_self_test_error ", (uint32_t)-result, "\n");
  if (result != BALANCE_OK) {
    return result;
  }
  if (usable != VERDICT_USABLE) {
    return -106; /* a product keeps its old controller */
  }
  if (is_one_body() == 0) {
    return -107;
  }
  parameters.kp = limited(identified, POSTURE_KP);
  parameters.kd = limited(identified, POSTURE_KD);
  parameters.kp_pass = limited(identified, POSTURE_KP_PASS);
  parameters.kd_pass = limited(identified, POSTURE_KD_PASS);
  parameters.theta = limited(identified, POSTURE_THETA);
  parameters.delay = limited(identified, POSTURE_DELAY);
  /* Not only a good fit: this body must stand with these gains, 10 ms of latency and torques 10% off. */
  result = balance_check(&parameters, 0.010, 1.1);
  if (result != BALANCE_OK) {
    return -108; /* a product keeps its old controller */
  }
  result = balance_begin(&controller, &parameters);
  for (step = 0; (step < 1000) && (result == BALANCE_OK); ++step) {
    double torque = 0.0;
    result = balance_step(&controller, 0.001, 0.002, 0.0, 0.0, &torque);
    largest = (torque > largest) ? torque : largest;
  }
  if (result == BALANCE_OK) {
    result = tell_steps(&parameters);
  }
  tell_checks();
  print_number("controller_stack_bytes ", stack_used(), "\n");
  print_number("controller_state_bytes ", (uint32_t)sizeof controller, "\n");
  return (largest > 0.0) ? -104 : result; /* it holds against the sway */
}

#if POSTURE_GIVES_DISTANCE
/* The distance of the last trial, which also counts in its verdict. */
static int tell_distance(void) {
  double distance = 0.0;
  int result;
  (void)instructions();
  result = posture_distance(&distance, &arena);
  print_number("instructions_distance ", instructions(), "\n");
  print_number("distance_thousandths ", (uint32_t)(1000.0 * distance), "\n");
  return result;
}
#endif

static int run(int32_t in, int32_t out) {
  float whole[POSTURE_PARAMETERS];
  float parts[POSTURE_PARAMETERS];
  const uint32_t bytes = (uint32_t)sizeof sway;
  const int32_t trials = host_length(in) / (int32_t)bytes;
  uint32_t most = 0U;
  cost spent = {0U, 0U, 0U};
  verdict usable;
  int32_t trial;
  int32_t i;
  int result;
  if (trials < 1) {
    return -105; /* the file has no whole trial */
  }
  start_counting();
  check_counter();
  (void)instructions();
  result = posture_self_test(&arena);
  print_number("instructions_self_test ", instructions(), "\n");
  print_number("self_test_error ", (uint32_t)-result, "\n");
  for (trial = 0; (trial < trials) && (result == POSTURE_OK); ++trial) {
    if (host_read(in, sway, bytes) != 0) {
      return -100;
    }
    paint_stack();
    (void)instructions();
    result = posture_identify(sway, whole, &arena);
    most = larger(most, instructions());
    if (trial == 0) {
      print_number("stack_bytes ", stack_used(), "\n");
    }
    if (result == POSTURE_OK) {
      result = identify_as_samples_arrive(parts, &spent);
    }
    for (i = 0; (i < POSTURE_PARAMETERS) && (result == POSTURE_OK); ++i) {
      if (((const uint32_t*)(const void*)whole)[i] != ((const uint32_t*)(const void*)parts)[i]) {
        result = -101; /* must be the same bits */
      }
    }
    if ((result == POSTURE_OK) && (host_write(out, whole, (uint32_t)sizeof whole) != 0)) {
      result = -102;
    }
  }
#if POSTURE_GIVES_DISTANCE
  if (result == POSTURE_OK) {
    result = tell_distance();
  }
#endif
  print_number("trials ", (uint32_t)trial, "\n");
  print_number("instructions_whole ", most, "\n");
  print_number("instructions_parts ", spent.all, "\n");
  print_number("instructions_largest_part ", spent.max_unit, "\n");
  print_number("instructions_after_last_sample ", spent.after_last_sample, "\n");
  usable = judge(result, whole, &arena);
  print_number("verdict ", (uint32_t)usable, "\n");
  return (result == POSTURE_OK) ? run_controller(whole, usable) : result;
}

int main(void) {
  const int32_t in = host_open("sway.bin", 0);
  const int32_t out = host_open("results.bin", 1);
  int result = -103;
  if ((in >= 0) && (out >= 0)) {
    result = run(in, out);
    host_close(in);
    host_close(out);
  }
  print_number("error ", (uint32_t)-result, "\n");
  host_exit((result == 0) ? 0 : 1);
  return result;
}
