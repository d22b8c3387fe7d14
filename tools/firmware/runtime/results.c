/* ---- Results --------------------------------------------------------------------------------------------------- */

/* Large samples or pixels, though finite, make sums that are not: such outputs are no result. */
static int32_t check_outputs(const work_state* state) {
  int32_t result = (state->phase == PHASE_DONE) ? DECID_FW_OK : DECID_FW_ERROR_STATE;
  int32_t i;
  for (i = 0; (i < OUTPUTS) && (result == DECID_FW_OK); ++i) {
    if (is_finite_float(state->outputs[i]) == 0) {
      result = DECID_FW_ERROR_NOT_FINITE;
    }
  }
  return result;
}

#if COMPONENTS > 0
/* A mixture of Gaussians in coordinates whose normal distribution function is the share of a parameter's range: decid's
   identify/network/mixture.hpp. */
#define SECTION (1 + PARAMETERS + ((PARAMETERS * (PARAMETERS + 1)) / 2)) /* outputs of one Gaussian */
#define LOG_DIAGONAL_LIMIT 7.0
#define NODES 25
#define NODES_REACH 6.0
#define NODES_SPACING 0.5

typedef struct {
  double weight[COMPONENTS];
  double variance[COMPONENTS][PARAMETERS];
} gaussians;

/* Row `row` of a lower triangle begins there. */
static int32_t triangle(int32_t row) {
  return (row * (row + 1)) / 2;
}

/* The diagonal of the covariance: of the inverse of A, times its transpose. */
static void find_variances(const float* section, double variance[PARAMETERS]) {
  double inverse[(PARAMETERS * (PARAMETERS + 1)) / 2];
  const float* below = &section[1 + (2 * PARAMETERS)];
  int32_t i;
  int32_t j;
  int32_t k;
  for (i = 0; i < PARAMETERS; ++i) {
    double* const row = &inverse[triangle(i)];
    double logarithm = (double)section[1 + PARAMETERS + i];
    double diagonal;
    logarithm = (logarithm < -LOG_DIAGONAL_LIMIT) ? -LOG_DIAGONAL_LIMIT : logarithm;
    logarithm = (logarithm > LOG_DIAGONAL_LIMIT) ? LOG_DIAGONAL_LIMIT : logarithm;
    diagonal = 1.0 / exponential(logarithm);
    for (j = 0; j < i; ++j) {
      row[j] = 0.0;
    }
    for (k = 0; k < i; ++k) {
      for (j = 0; j <= k; ++j) {
        row[j] = fma_double((double)below[k], inverse[triangle(k) + j], row[j]);
      }
    }
    for (j = 0; j < i; ++j) {
      row[j] = row[j] * -diagonal;
    }
    row[i] = diagonal;
    below = &below[i];
    variance[i] = 0.0;
    for (j = 0; j <= i; ++j) {
      variance[i] = fma_double(row[j], row[j], variance[i]);
    }
  }
}

static void find_gaussians(const float* outputs, gaussians* found) {
  double highest = (double)outputs[0];
  double sum = 0.0;
  int32_t k;
  for (k = 1; k < COMPONENTS; ++k) {
    const double weight = (double)outputs[k * SECTION];
    highest = (weight > highest) ? weight : highest;
  }
  for (k = 0; k < COMPONENTS; ++k) {
    sum = sum + exponential((double)outputs[k * SECTION] - highest);
  }
  sum = highest + natural_log(sum);
  for (k = 0; k < COMPONENTS; ++k) {
    found->weight[k] = exponential((double)outputs[k * SECTION] - sum);
    find_variances(&outputs[k * SECTION], found->variance[k]);
  }
}

/* Mean of the share of a parameter's range. */
static double mean_share(const float* outputs, const gaussians* of, int32_t parameter) {
  double sum = 0.0;
  int32_t k;
  for (k = 0; k < COMPONENTS; ++k) {
    const double centre = (double)outputs[(k * SECTION) + 1 + parameter];
    sum = sum + (of->weight[k] * normal_distribution(centre / square_root(1.0 + of->variance[k][parameter])));
  }
  return sum;
}

/* Standard deviation of it. */
static double deviation_of_share(const float* outputs, const gaussians* of, const double node[NODES],
                                 int32_t parameter) {
  const double mean = mean_share(outputs, of, parameter);
  double moment = 0.0;
  double variance;
  int32_t i;
  int32_t k;
  for (k = 0; k < COMPONENTS; ++k) {
    const double centre = (double)outputs[(k * SECTION) + 1 + parameter];
    const double own = of->variance[k][parameter];
    const double deviation = square_root(own);
    const double slope = own / deviation;
    double sum = 0.0;
    for (i = 0; i < NODES; ++i) {
      const double deviate = (NODES_SPACING * (double)i) - NODES_REACH;
      sum = sum + ((node[i] * normal_distribution(centre + (deviation * deviate))) *
                   normal_distribution(centre + (slope * deviate)));
    }
    moment = moment + (of->weight[k] * sum);
  }
  variance = moment - (mean * mean);
  return (variance > 0.0) ? square_root(variance) : 0.0;
}

static void find_scores(const float* outputs, float scores[PARAMETERS]) {
  gaussians found;
  int32_t i;
  find_gaussians(outputs, &found);
  for (i = 0; i < PARAMETERS; ++i) {
    scores[i] = (float)((mean_share(outputs, &found, i) - 0.5) * ROOT_TWELVE);
  }
}

static int32_t take_stddevs(void* arena, float* stddevs) {
  const work_state* const state = state_of(arena);
  float made[PARAMETERS];
  gaussians found;
  double node[NODES];
  double whole = 0.0;
  int32_t i;
  int32_t result = check_outputs(state);
  if (result != DECID_FW_OK) {
    return result;
  }
  for (i = 0; i < NODES; ++i) {
    node[i] = normal_density((NODES_SPACING * (double)i) - NODES_REACH);
    whole = whole + node[i];
  }
  for (i = 0; i < NODES; ++i) {
    node[i] = node[i] / whole;
  }
  find_gaussians(state->outputs, &found);
  for (i = 0; i < PARAMETERS; ++i) {
    made[i] = (float)((parameter_range[i] * deviation_of_share(state->outputs, &found, node, i)) * deviation_factor[i]);
    if (is_finite_float(made[i]) == 0) {
      result = DECID_FW_ERROR_NOT_FINITE;
    }
  }
  for (i = 0; (i < PARAMETERS) && (result == DECID_FW_OK); ++i) {
    stddevs[i] = made[i];
  }
  return result;
}
#else
static void find_scores(const float* outputs, float scores[PARAMETERS]) {
  int32_t i;
  for (i = 0; i < PARAMETERS; ++i) {
    scores[i] = outputs[i];
  }
}
#endif

static int32_t take_result(void* arena, float* parameters) {
  const work_state* const state = state_of(arena);
  float scores[PARAMETERS];
  float made[PARAMETERS];
  int32_t i;
  int32_t result = check_outputs(state);
  if (result != DECID_FW_OK) {
    return result;
  }
  find_scores(state->outputs, scores);
  for (i = 0; i < PARAMETERS; ++i) {
    /* Not volatile, gcc 12 at -O3 vectorises the way from double to float and back to double, and does not round. */
    const volatile float score = scores[i];
#if OTHER_BODY
    made[i] = (float)((target_mean[i] + ((double)score * target_deviation[i])) * body_factor[i]);
#else
    made[i] = (float)(target_mean[i] + ((double)score * target_deviation[i]));
#endif
    if (is_finite_float(made[i]) == 0) {
      result = DECID_FW_ERROR_NOT_FINITE;
    }
  }
  for (i = 0; (i < PARAMETERS) && (result == DECID_FW_OK); ++i) {
    parameters[i] = made[i];
  }
  return result;
}
