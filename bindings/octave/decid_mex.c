/* decid for Octave and MATLAB: decid_identify.m and the others call decid_mex(command, source, options), options being
   a structure whose fields are those of the lists below. Everything it does is libdecid's (decid.h). */
#include <decid/decid.h>
#include <mex.h>
#include <stdio.h>
#include <string.h>

/* The memory of a call; an error of Octave's never returns, so it is freed before. */
static decid_model* model;       /* the last one that was used, kept for the next call */
static char model_path[4096];    /* of it; "": the built-in one */
static decid_protocol* protocol; /* these are of one call */
static decid_recording* recording;
static decid_trials* trials;
static decid_result* result;
static decid_study* study;
static char texts[16][4096]; /* options that are texts */
static int used_texts;

static void forget_call(void) {
  decid_study_free(study);
  decid_result_free(result);
  decid_recording_free(recording);
  decid_trials_free(trials);
  decid_protocol_free(protocol);
  study = NULL;
  result = NULL;
  recording = NULL;
  trials = NULL;
  protocol = NULL;
  used_texts = 0;
}

static void forget_model(void) {
  decid_model_free(model);
  model = NULL;
}

/* `identifier`: "decid:" and a code of docs/reference/errors.md. */
static void fail(const char* identifier, const char* where, const char* problem, const char* remedy) {
  forget_call();
  mexErrMsgIdAndTxt(identifier, "%s: %s; %s", where, problem, remedy);
}

static void require(decid_status status) {
  static char text[4096], identifier[64];
  if (status == DECID_OK) return;
  snprintf(text, sizeof text, "%s", decid_error_text());
  snprintf(identifier, sizeof identifier, "decid:%s", decid_error_code());
  forget_call();
  mexErrMsgIdAndTxt(identifier, "%s", text);
}

/* ---- Options ---- */

#define READ_OPTIONS                                                                                          \
  "rate", "unit", "column", "fill_gaps", "tilt_column", "invert_sway", "invert_tilt", "tilt_unit", "section", \
      "trial_column", "trial", "missing", "skip_lines", "com_height", "leg", "trunk", "hip", "shoulder", "ankle"
#define IDENTIFY_OPTIONS READ_OPTIONS, "tilt", "mass", "height", "begin", "detrend", "model"
static const char* const identify_options[] = {IDENTIFY_OPTIONS, NULL};
static const char* const fit_options[] = {IDENTIFY_OPTIONS, "protocol",     "prior_start", "prior_gain",
                                          "prior_noise",    "max_draws",    "seed",        "ranges",
                                          "priors",         "moved_before", "controllers", NULL};
static const char* const read_options[] = {READ_OPTIONS, "height", NULL};
static const char* const only_of_files[] = {"column", "fill_gaps", "tilt_column", "section",    "trial_column",
                                            "trial",  "missing",   "skip_lines",  "com_height", "leg",
                                            "trunk",  "hip",       "shoulder",    "ankle"};
static const char* const trial_names_options[] = {"section", "trial_column", "skip_lines", NULL};
static const char* const study_options[] = {"group", "within",    "covariates", "fit",         "joint", "free",
                                            "model", "max_draws", "seed",       "controllers", NULL};

static int is_one_of(const char* name, const char* const* names) {
  for (; *names != NULL; ++names)
    if (strcmp(name, *names) == 0) return 1;
  return 0;
}

static void refuse_unknown(const mxArray* options, const char* const* names) {
  int i;
  for (i = 0; i < mxGetNumberOfFields(options); ++i)
    if (!is_one_of(mxGetFieldNameByNumber(options, i), names)) {
      static char name[128];
      snprintf(name, sizeof name, "there is no option '%s'", mxGetFieldNameByNumber(options, i));
      fail("decid:setting_unknown", "decid", name, "help names the options");
    }
}

static double number(const mxArray* options, const char* name, double otherwise) {
  const mxArray* value = mxGetField(options, 0, name);
  if (value == NULL) return otherwise;
  if (!(mxIsNumeric(value) || mxIsLogical(value)) || mxIsComplex(value) || mxGetNumberOfElements(value) != 1)
    fail("decid:setting_malformed", name, "is no number", "give one");
  return mxGetScalar(value);
}

static int whole(const mxArray* options, const char* name, int otherwise) {
  const double value = number(options, name, otherwise);
  if (!(value >= -1e9 && value <= 1e9) || value != (int)value)
    fail("decid:setting_malformed", name, "is no whole number", "give one");
  return (int)value;
}

/* -1: decid finds them. */
static int lines_to_skip(const mxArray* options) {
  const int lines = whole(options, "skip_lines", -1);
  if (mxGetField(options, 0, "skip_lines") != NULL && lines < 0)
    fail("decid:setting_out_of_range", "skip_lines", "is negative", "give 0 or more");
  return lines;
}

static uint64_t seed_of(const mxArray* options, uint64_t otherwise) {
  const int seed = whole(options, "seed", (int)otherwise);
  if (seed < 0) fail("decid:setting_out_of_range", "seed", "is negative", "give 0 or more");
  return (uint64_t)seed;
}

/* NULL if it is not given. */
static const char* text(const mxArray* options, const char* name) {
  const mxArray* value = mxGetField(options, 0, name);
  if (value == NULL) return NULL;
  if (!mxIsChar(value) || mxGetString(value, texts[used_texts], sizeof texts[0]) != 0)
    fail("decid:setting_malformed", name, "is no text, or a long one", "give a name in quotes");
  return texts[used_texts++];
}

static int choice(const mxArray* options, const char* name, const char* const* names) {
  const char* given = text(options, name);
  int i;
  if (given == NULL) return 0;
  --used_texts;
  for (i = 0; names[i] != NULL; ++i)
    if (strcmp(given, names[i]) == 0) return i;
  fail("decid:setting_unknown", name, "is none of its values", "help names them");
  return 0;
}

enum { max_priors = 64 };
static const char* const units[] = {"", "deg", "rad", "mrad", "mm", "cm", "m", NULL};
static const char* const detrends[] = {"none", "offset", "linear", NULL};

/* ---- Values for Octave ---- */

static mxArray* row(const double* values, size_t count) {
  mxArray* made = mxCreateDoubleMatrix(1, count, mxREAL);
  if (count > 0) memcpy(mxGetPr(made), values, count * sizeof *values);
  return made;
}

static mxArray* column_of(const double* values, size_t count) {
  mxArray* made = row(values, count);
  mxSetM(made, count);
  mxSetN(made, 1);
  return made;
}

static mxArray* column_of_floats(const float* values, size_t count) {
  mxArray* made = mxCreateDoubleMatrix(count, 1, mxREAL);
  size_t i;
  for (i = 0; i < count; ++i) mxGetPr(made)[i] = values[i];
  return made;
}

static void add(mxArray* structure, const char* name, mxArray* value) {
  mxAddField(structure, name);
  mxSetField(structure, 0, name, value);
}

static mxArray* structure(void) {
  return mxCreateStructMatrix(1, 1, 0, NULL);
}

static mxArray* warnings_of(const void* of, size_t count, const decid_warning* (*get)(const void*, size_t)) {
  static const char* fields[] = {"severity", "code", "text"};
  static const char* severities[] = {"info", "caution", "invalid"};
  mxArray* list = mxCreateStructMatrix(1, count, 3, fields);
  size_t i;
  for (i = 0; i < count; ++i) {
    const decid_warning* warning = get(of, i);
    mxSetField(list, i, "severity", mxCreateString(severities[warning->severity]));
    mxSetField(list, i, "code", mxCreateString(warning->code));
    mxSetField(list, i, "text", mxCreateString(warning->text));
  }
  return list;
}
static const decid_warning* warning_of_recording(const void* of, size_t i) {
  return decid_recording_warning(of, i);
}
static const decid_warning* warning_of_result(const void* of, size_t i) {
  return decid_result_warning(of, i);
}

static mxArray* parameters_of(size_t first, size_t end) {
  static const char* fields[] = {"name", "unit",           "low",        "high",       "value",
                                 "sd",   "interval50",     "interval90", "normalized", "normalized_interval90",
                                 "rhat", "effective_draws"};
  mxArray* list = mxCreateStructMatrix(1, end - first, 12, fields);
  size_t i;
  for (i = 0; i < end - first; ++i) {
    const decid_parameter* of = decid_result_parameter(result, first + i);
    mxSetField(list, i, "name", mxCreateString(of->name));
    mxSetField(list, i, "unit", mxCreateString(of->unit));
    mxSetField(list, i, "low", row(&of->low, 1));
    mxSetField(list, i, "high", row(&of->high, 1));
    mxSetField(list, i, "value", row(&of->value, 1));
    mxSetField(list, i, "sd", row(&of->sd, 1));
    mxSetField(list, i, "interval50", row(of->interval50, 2));
    mxSetField(list, i, "interval90", row(of->interval90, 2));
    mxSetField(list, i, "normalized", row(&of->normalized, 1));
    mxSetField(list, i, "normalized_interval90", row(of->normalized_interval90, 2));
    mxSetField(list, i, "rhat", row(&of->rhat, 1));
    mxSetField(list, i, "effective_draws", row(&of->effective_draws, 1));
  }
  return list;
}

static mxArray* comparison(void) {
  static const char* fields[] = {
      "controller", "log_predictive_density", "difference", "difference_standard_error", "weight", "comparable"};
  const size_t count = decid_result_controllers(result);
  mxArray* list = mxCreateStructMatrix(1, count, 6, fields);
  size_t i;
  for (i = 0; i < count; ++i) {
    const decid_compared_controller* of = decid_result_controller(result, i);
    mxSetField(list, i, "controller", mxCreateString(of->controller));
    mxSetField(list, i, "log_predictive_density", row(&of->log_predictive_density, 1));
    mxSetField(list, i, "difference", row(&of->difference, 1));
    mxSetField(list, i, "difference_standard_error", row(&of->difference_standard_error, 1));
    mxSetField(list, i, "weight", row(&of->weight, 1));
    mxSetField(list, i, "comparable", mxCreateLogicalScalar(of->comparable != 0));
  }
  return list;
}

static void add_fit(mxArray* to) {
  const decid_sampling* sampling = decid_result_sampling(result);
  const size_t parameters = decid_result_parameters(result), quantities = decid_result_quantities(result);
  mxArray* draws = structure();
  size_t q;
  for (q = 0; q < quantities; ++q)
    add(draws, decid_result_parameter(result, q)->name,
        column_of(decid_result_draws(result, q), (size_t)sampling->draws));
  add(to, "quantities", parameters_of(parameters, quantities));
  add(to, "draws", draws);
  add(to, "chains", mxCreateDoubleScalar(sampling->chains));
  add(to, "agreed", mxCreateLogicalScalar(sampling->agreed != 0));
  add(to, "from_network", mxCreateLogicalScalar(sampling->from_network != 0));
  add(to, "divergences", mxCreateDoubleScalar(sampling->divergences));
  add(to, "comparison", comparison());
}

static mxArray* result_to_octave(void) {
  static const char* trusts[] = {"usable", "caution", "not usable"};
  const decid_figures* figures = decid_result_figures(result);
  mxArray* made = structure();
  const float* values;
  size_t samples;
  add(made, "trust", mxCreateString(trusts[decid_result_trust(result)]));
  add(made, "parameters", parameters_of(0, decid_result_parameters(result)));
  add(made, "warnings", warnings_of(result, decid_result_warnings(result), warning_of_result));
  add(made, "rms_residual_deg", row(&figures->rms_residual_deg, 1));
  add(made, "variance_accounted_for", row(&figures->variance_accounted_for, 1));
  add(made, "peak_to_peak_deg", row(&figures->peak_to_peak_deg, 1));
  add(made, "response_ratio", row(&figures->response_ratio, 1));
  add(made, "ood_score", row(&figures->ood_score, 1));
  add(made, "tilt_delay_s", row(&figures->tilt_delay_s, 1));
  add(made, "tilt_correlation", row(&figures->tilt_correlation, 1));
  add(made, "tilt_gain", row(&figures->tilt_gain, 1));
  add(made, "mass_kg", row(&figures->mass_kg, 1));
  add(made, "com_height_m", row(&figures->com_height_m, 1));
  add(made, "inertia_kgm2", row(&figures->inertia_kgm2, 1));
  add(made, "body_assumed", mxCreateLogicalScalar(figures->body_assumed != 0));
  values = decid_result_sway(result, &samples);
  add(made, "sway", column_of_floats(values, samples));
  values = decid_result_fitted(result, &samples);
  add(made, "fitted", column_of_floats(values, samples));
  if (decid_result_sampling(result) != NULL) add_fit(made);
  return made;
}

/* ---- Commands ---- */

/* Copies the options that choose a table and a recording of the file. */
static void take_part(const mxArray* options, decid_read_options* how) {
  how->section = text(options, "section");
  how->trial_column = text(options, "trial_column");
  how->trial = text(options, "trial");
}

/* Copies the sources of the sway where there is no column of it. */
static void take_sources(const mxArray* options, decid_read_options* how) {
  how->com_height_m = number(options, "com_height", 0.0);
  how->leg_column = text(options, "leg");
  how->trunk_column = text(options, "trunk");
  how->hip_column = text(options, "hip");
  how->shoulder_column = text(options, "shoulder");
  how->ankle_column = text(options, "ankle");
  if (how->hip_column != NULL || how->shoulder_column != NULL || how->com_height_m != 0.0)
    how->body_height_m = number(options, "height", 0.0);
}

static int is_vector_of_doubles(const mxArray* value) {
  return mxIsDouble(value) && !mxIsComplex(value) && !mxIsSparse(value) && (mxGetM(value) == 1 || mxGetN(value) == 1);
}

static void take_samples(const mxArray* source, const mxArray* options) {
  const mxArray* tilt = mxGetField(options, 0, "tilt");
  decid_samples_options how;
  size_t i;
  if (!is_vector_of_doubles(source))
    fail("decid:setting_malformed", "decid", "the recording is neither a name in quotes nor a vector of doubles",
         "give one of the two");
  if (mxGetField(options, 0, "rate") == NULL || mxGetField(options, 0, "unit") == NULL)
    fail("decid:setting_missing", "rate, unit", "samples do not say theirs",
         "give both, such as 'rate', 100, 'unit', 'deg'");
  for (i = 0; i < sizeof only_of_files / sizeof only_of_files[0]; ++i)
    if (mxGetField(options, 0, only_of_files[i]) != NULL)
      fail("decid:setting_conflict", only_of_files[i], "is for files", "leave it out");
  decid_samples_defaults(&how, sizeof how);
  how.unit = choice(options, "unit", units);
  how.tilt_unit = choice(options, "tilt_unit", units);
  how.invert_sway = whole(options, "invert_sway", 0);
  how.invert_tilt = whole(options, "invert_tilt", 0);
  how.mean_is_upright = choice(options, "detrend", detrends) != 0;
  if (tilt != NULL) {
    if (!is_vector_of_doubles(tilt))
      fail("decid:setting_malformed", "tilt", "is no vector of doubles", "give one value per sample of the sway");
    if (mxGetNumberOfElements(tilt) != mxGetNumberOfElements(source))
      fail("decid:size_mismatch", "tilt", "has another length than the sway",
           "give signals that were sampled together");
    how.tilt = mxGetPr(tilt);
  }
  require(decid_recording_of_samples(mxGetPr(source), mxGetNumberOfElements(source), number(options, "rate", 0.0), &how,
                                     &recording));
}

/* A file that is named, or samples. */
static void take_recording(const mxArray* source, const mxArray* options) {
  static char path[4096];
  if (mxIsChar(source)) {
    decid_read_options how;
    decid_read_defaults(&how, sizeof how);
    if (mxGetString(source, path, sizeof path) != 0)
      fail("decid:setting_out_of_range", "decid", "the path is too long", "give a shorter one");
    if (mxGetField(options, 0, "tilt") != NULL)
      fail("decid:setting_conflict", "tilt", "is for samples", "name the file's column with tilt_column");
    how.column = text(options, "column");
    how.unit = choice(options, "unit", units);
    how.rate_hz = number(options, "rate", 0.0);
    how.fill_gaps_s = number(options, "fill_gaps", 0.0);
    how.tilt_column = text(options, "tilt_column");
    how.tilt_unit = choice(options, "tilt_unit", units);
    how.invert_sway = whole(options, "invert_sway", 0);
    how.invert_tilt = whole(options, "invert_tilt", 0);
    how.skip_lines = lines_to_skip(options);
    const double missing = number(options, "missing", 0.0);
    if (mxGetField(options, 0, "missing") != NULL) how.missing_value = &missing;
    how.mean_is_upright = choice(options, "detrend", detrends) != 0;
    take_part(options, &how);
    take_sources(options, &how);
    require(decid_recording_read(path, &how, &recording));
    return;
  }
  take_samples(source, options);
}

static void take_model(const mxArray* options) {
  const char* path = text(options, "model");
  const char* wanted = path == NULL ? "" : path;
  if (model != NULL && *wanted == '\0' && *model_path == '\0') return;
  forget_model();
  snprintf(model_path, sizeof model_path, "%s", wanted);
  require(decid_model_load(path, &model));
}

static mxArray* identify(const mxArray* source, const mxArray* options) {
  decid_identify_options how;
  refuse_unknown(options, identify_options);
  decid_identify_defaults(&how, sizeof how);
  how.mass_kg = number(options, "mass", 0.0);
  how.height_m = number(options, "height", 0.0);
  how.begin_s = number(options, "begin", how.begin_s);
  how.detrend = choice(options, "detrend", detrends);
  take_model(options);
  take_recording(source, options);
  require(decid_identify(model, recording, &how, &result));
  return result_to_octave();
}

/* Reads the given ranges and normal distributions, both structs of pairs by the parameters' names. */
static size_t take_priors(const mxArray* options, decid_parameter_prior* priors) {
  static const char* const kinds[] = {"ranges", "priors"};
  size_t count = 0, kind, i;
  for (kind = 0; kind < 2; ++kind) {
    const mxArray* given = mxGetField(options, 0, kinds[kind]);
    if (given == NULL) continue;
    if (!mxIsStruct(given) || mxGetNumberOfElements(given) != 1)
      fail("decid:setting_malformed", kinds[kind], "is not a struct", "give one such as struct ('delay', [0.05 0.2])");
    for (i = 0; i < (size_t)mxGetNumberOfFields(given); ++i) {
      const char* name = mxGetFieldNameByNumber(given, (int)i);
      const mxArray* pair = mxGetFieldByNumber(given, 0, (int)i);
      size_t place = 0;
      if (!is_vector_of_doubles(pair) || mxGetNumberOfElements(pair) != 2)
        fail("decid:setting_malformed", name, "has no pair of numbers", "give two, such as [0.05 0.2]");
      while (place < count && strcmp(priors[place].name, name) != 0) ++place;
      if (place == max_priors)
        fail("decid:setting_out_of_range", kinds[kind], "has too many fields", "give one a parameter");
      if (place == count) {
        const decid_parameter_prior none = {name, mxGetNaN(), mxGetNaN(), mxGetNaN(), mxGetNaN()};
        priors[count++] = none;
      }
      if (kind == 0) {
        priors[place].low = mxGetPr(pair)[0];
        priors[place].high = mxGetPr(pair)[1];
      } else {
        priors[place].mean = mxGetPr(pair)[0];
        priors[place].sd = mxGetPr(pair)[1];
      }
    }
  }
  return count;
}

static mxArray* fit(const mxArray* source, const mxArray* options) {
  static decid_parameter_prior priors[max_priors];
  decid_fit_options how;
  const char* played;
  refuse_unknown(options, fit_options);
  decid_fit_defaults(&how, sizeof how);
  how.mass_kg = number(options, "mass", 0.0);
  how.height_m = number(options, "height", 0.0);
  how.begin_s = number(options, "begin", how.begin_s);
  how.detrend = choice(options, "detrend", detrends);
  how.prior_start_s = number(options, "prior_start", how.prior_start_s);
  how.prior_gain = number(options, "prior_gain", how.prior_gain);
  how.prior_noise_deg = number(options, "prior_noise", how.prior_noise_deg);
  how.max_draws = whole(options, "max_draws", how.max_draws);
  how.seed = seed_of(options, how.seed);
  how.moved_before = whole(options, "moved_before", 0);
  how.parameter_prior_count = take_priors(options, priors);
  how.parameter_priors = priors;
  how.controllers = text(options, "controllers");
  played = text(options, "protocol");
  if (played != NULL) require(decid_protocol_load(played, &protocol));
  how.protocol = protocol;
  take_model(options);
  take_recording(source, options);
  require(decid_fit(model, recording, &how, &result));
  return result_to_octave();
}

static mxArray* read_recording(const mxArray* source, const mxArray* options) {
  mxArray* made;
  size_t samples;
  refuse_unknown(options, read_options);
  if (!mxIsChar(source))
    fail("decid:setting_malformed", "decid_read", "the file's name is no text", "give it in quotes");
  take_recording(source, options);
  samples = decid_recording_samples(recording);
  made = structure();
  add(made, "sway", column_of(decid_recording_sway(recording), samples));
  if (decid_recording_tilt(recording) != NULL) add(made, "tilt", column_of(decid_recording_tilt(recording), samples));
  add(made, "rate", mxCreateDoubleScalar(decid_recording_rate_hz(recording)));
  add(made, "column", mxCreateString(decid_recording_column(recording)));
  add(made, "warnings", warnings_of(recording, decid_recording_warnings(recording), warning_of_recording));
  return made;
}

static mxArray* trial_names(const mxArray* source, const mxArray* options) {
  static char path[4096];
  decid_read_options how;
  mxArray* names;
  size_t i, count;
  refuse_unknown(options, trial_names_options);
  if (!mxIsChar(source) || mxGetString(source, path, sizeof path) != 0)
    fail("decid:setting_malformed", "decid_trial_names", "the file's name is no text, or a long one",
         "give it in quotes");
  decid_read_defaults(&how, sizeof how);
  how.skip_lines = lines_to_skip(options);
  take_part(options, &how);
  require(decid_trials_read(path, &how, &trials));
  count = decid_trials_count(trials);
  names = mxCreateCellMatrix(1, count);
  for (i = 0; i < count; ++i) mxSetCell(names, i, mxCreateString(decid_trials_name(trials, i)));
  return names;
}

/* The JSON of a study, which decid_study.m decodes. */
static mxArray* run_study(const mxArray* source, const mxArray* options) {
  static char path[4096];
  decid_study_options how;
  refuse_unknown(options, study_options);
  if (!mxIsChar(source) || mxGetString(source, path, sizeof path) != 0)
    fail("decid:setting_malformed", "decid_study", "the sheet's name is no text, or a long one", "give it in quotes");
  decid_study_defaults(&how, sizeof how);
  how.by_group = whole(options, "group", 0);
  how.within = text(options, "within");
  how.covariates = text(options, "covariates");
  how.fit = whole(options, "fit", 0);
  how.joint = text(options, "joint");
  how.free = text(options, "free");
  how.controllers = text(options, "controllers");
  how.max_draws = whole(options, "max_draws", how.max_draws);
  how.seed = seed_of(options, how.seed);
  take_model(options);
  require(decid_study_run(model, path, &how, &study));
  return mxCreateString(decid_study_json(study));
}

/* Options: seed, protocol, controller, and each parameter by its name. */
static mxArray* simulate(const mxArray* options) {
  double values[DECID_MAX_PARAMETERS];
  const char* names[DECID_MAX_PARAMETERS + 4] = {"seed", "protocol", "controller"};
  const char* played = text(options, "protocol");
  const char* controller = text(options, "controller");
  const uint64_t seed = seed_of(options, 1);
  size_t p, count, samples;
  mxArray *made, *sway;
  require(decid_protocol_load_controller(played == NULL ? "default" : played, controller, &protocol));
  count = decid_protocol_parameters(protocol);
  samples = decid_protocol_samples(protocol);
  if (count > DECID_MAX_PARAMETERS)
    fail("decid:not_supported", "controller", "has more parameters than this file holds",
         "compile it with decid's header");
  for (p = 0; p < count; ++p) names[p + 3] = decid_protocol_parameter(protocol, p)->name;
  refuse_unknown(options, names);
  for (p = 0; p < count; ++p) {
    const decid_parameter_info* info = decid_protocol_parameter(protocol, p);
    values[p] = number(options, info->name, 0.5 * (info->low + info->high));
  }
  made = structure();
  sway = mxCreateDoubleMatrix(samples, 1, mxREAL);
  require(decid_simulate(protocol, values, 1, seed, mxGetPr(sway), NULL));
  add(made, "sway", sway);
  add(made, "tilt", column_of(decid_protocol_tilt(protocol), samples));
  add(made, "rate", mxCreateDoubleScalar(decid_protocol_rate_hz(protocol)));
  for (p = 0; p < count; ++p) add(made, names[p + 3], mxCreateDoubleScalar(values[p]));
  return made;
}

void mexFunction(int outputs, mxArray** left, int inputs, const mxArray** right) {
  char command[16] = "";
  mexAtExit(forget_model);
  forget_call(); /* of a call that ran out of memory */
  require(decid_name_settings(DECID_PLAIN_NAMES));
  if (outputs > 1 || inputs != 3 || mxGetString(right[0], command, sizeof command) != 0 || !mxIsStruct(right[2]) ||
      mxGetNumberOfElements(right[2]) != 1)
    fail("decid:setting_malformed", "decid_mex", "is called in another way than its functions do",
         "call decid_identify and the others");
  if (strcmp(command, "identify") == 0)
    left[0] = identify(right[1], right[2]);
  else if (strcmp(command, "fit") == 0)
    left[0] = fit(right[1], right[2]);
  else if (strcmp(command, "read") == 0)
    left[0] = read_recording(right[1], right[2]);
  else if (strcmp(command, "trial_names") == 0)
    left[0] = trial_names(right[1], right[2]);
  else if (strcmp(command, "study") == 0)
    left[0] = run_study(right[1], right[2]);
  else if (strcmp(command, "simulate") == 0)
    left[0] = simulate(right[2]);
  else
    fail("decid:setting_unknown", "decid_mex", "there is no such command", "call decid_identify and the others");
  forget_call();
}
