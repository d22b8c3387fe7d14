/* decid in C: identifies the parameters of the DEC posture-control model from recordings of body sway on a tilting
   platform. This header is the manual of libdecid; angles are in rad and times in s unless a name says otherwise.

     decid_model* model = NULL;
     decid_recording* recording = NULL;
     decid_result* result = NULL;
     if (decid_model_load(NULL, &model) || decid_recording_read("recording.csv", NULL, &recording) ||
         decid_identify(model, recording, NULL, &result))
       fprintf(stderr, "%s\n", decid_error_text());
     for (size_t p = 0; p < decid_result_parameters(result); ++p) {
       const decid_parameter* found = decid_result_parameter(result, p);
       printf("%-8s %g, from %g to %g %s\n", found->name, found->value, found->interval90[0],
              found->interval90[1], found->unit);
     }

   Errors. Every function that can fail returns a decid_status. Unless it is DECID_OK, nothing was made or changed, and
   the thread's decid_error_..() give the code, the place, the problem and the remedy. A function that makes a handle
   stores it in its last argument, or NULL if it fails. No C++ exception leaves the library, and it never prints, exits
   or aborts. Where the system has no thread left, the OpenMP runtime ends the process.

   Ownership. Free each handle with the decid_.._free() of its type, in any order; these take NULL. A pointer that an
   accessor returns belongs to the accessor's handle, and lives as long. Accessors give 0 or NULL for a NULL handle and
   for an index that is too large.

   Threads. All functions may be called from many threads at once. A handle that a function takes as const may be used
   by many threads at once, and no handle changes once it is made. Results do not depend on the number of threads or the
   machine. A fork has none of OpenMP's threads: in a process that was forked after a call with several threads every
   function that can fail returns DECID_BAD_INPUT. After calls with one thread a fork computes as its parent does:
   make decid_set_threads(1) the first call of each thread, or set OMP_NUM_THREADS=1.

   Options. Set a structure of options with its decid_.._defaults(&options, sizeof options), then change it; NULL
   means all defaults. A comment names a default in brackets; others are 0 or NULL. Structures that the library returns
   may grow at their ends, so it returns pointers to them.

   Versions. DECID_ABI and the library's SONAME change when a function is removed or changes its meaning, not when
   one is added. decid_abi() returns the DECID_ABI of the running library. */
#ifndef DECID_H
#define DECID_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define DECID_API __attribute__((visibility("default")))
#define DECID_ABI 1

/* ---- Errors ---- */

typedef enum decid_status {
  DECID_OK = 0,
  DECID_FAILED = 1,    /* any other failure: a bug in decid */
  DECID_BAD_INPUT = 2, /* an argument, a file or a recording, or a disk that is full; the text names it */
  DECID_NO_MEMORY = 3,
  DECID_STOPPED = 4 /* a callback asked for it */
} decid_status;

/* The error of this thread's last call that failed; "" before any. Valid until the thread's next call that fails.
   text: "where: problem; remedy"; code: "file_missing" and so on, for programs (docs/reference/errors.md). */
DECID_API const char* decid_error_text(void);
DECID_API const char* decid_error_code(void);
DECID_API const char* decid_error_where(void);
DECID_API const char* decid_error_problem(void);
DECID_API const char* decid_error_remedy(void);

DECID_API int decid_abi(void);
DECID_API const char* decid_version(void); /* "0.2.0" */

/* Sets the number of threads for this thread's calls, 1 to 1024; the default is OMP_NUM_THREADS, of which decid uses
   1024 at most, or all cores. The call starts none. */
DECID_API decid_status decid_set_threads(int threads);

typedef enum decid_setting_names { DECID_FIELD_NAMES = 0, DECID_PLAIN_NAMES = 1 } decid_setting_names;

/* Sets how messages of the whole process name settings: by the fields of these structures, such as begin_s and
   leg_column [DECID_FIELD_NAMES], or as begin and leg, for bindings to languages whose arguments have these names. Call
   it before other functions; names: a decid_setting_names. */
DECID_API decid_status decid_name_settings(int names);

/* Called during long work with the fraction done, 0 to 1, and the name of the stage. A return value other than 0 stops
   the work, which then returns DECID_STOPPED. One thread at a time calls it, perhaps not the caller's; it must return,
   without longjmp. */
typedef int (*decid_progress)(void* user, double done, const char* stage);

typedef enum decid_severity {
  DECID_INFO = 0,    /* an assumption or a correction without harm */
  DECID_CAUTION = 1, /* the result may be off */
  DECID_INVALID = 2  /* do not use it unless you have found the cause */
} decid_severity;

typedef struct decid_warning {
  decid_severity severity;
  const char* code; /* for programs, stable: docs/guide/warnings.md lists them */
  const char* text; /* for people */
} decid_warning;

/* ---- Protocols: the platform's movement, the body on it, and the recording ---- */

typedef struct decid_protocol decid_protocol;

typedef struct decid_parameter_info {
  const char* name;        /* "Kp_pass" */
  const char* unit;        /* "N m/rad"; "1" for a plain number */
  const char* description; /* "Passive stiffness" */
  double low, high;        /* the range of training, for the protocol's body */
  int scales_with_mgh;     /* 1: value / (m g h) has a meaning */
} decid_parameter_info;

/* "default", "short", or the path of a JSON file (docs/reference/protocols.md). */
DECID_API decid_status decid_protocol_load(const char* name_or_path, decid_protocol** protocol);
/* The same with a controller: a name of decid_controller_name, or NULL for the protocol's. A file that names another
   controller is DECID_BAD_INPUT. The controller determines the parameters. */
DECID_API decid_status decid_protocol_load_controller(const char* name_or_path, const char* controller,
                                                      decid_protocol** protocol);
DECID_API const char* decid_protocol_controller(const decid_protocol* protocol); /* "dec" */
/* Controllers: "dec", the paper's, and others (docs/reference/posture-model.md); NULL for an index beyond them. */
DECID_API size_t decid_controllers(void);
DECID_API const char* decid_controller_name(size_t index);
DECID_API const char* decid_controller_description(size_t index);
DECID_API void decid_protocol_free(decid_protocol* protocol);
DECID_API size_t decid_protocol_samples(const decid_protocol* protocol); /* of a trial */
DECID_API double decid_protocol_rate_hz(const decid_protocol* protocol);
DECID_API const char* decid_protocol_json(const decid_protocol* protocol);   /* complete */
DECID_API const double* decid_protocol_tilt(const decid_protocol* protocol); /* of the platform, rad; samples values */
DECID_API size_t decid_protocol_parameters(const decid_protocol* protocol);
DECID_API const decid_parameter_info* decid_protocol_parameter(const decid_protocol* protocol, size_t index);

/* Simulates recorded trials of the single pendulum, trial i with the noise of seed + i: the bits of `decid simulate
   --seed`. parameters: trials x decid_protocol_parameters values, in SI units; sway_rad: trials
   x samples values, NaN from where a body falls. valid: trials values, 1 unless the body fell; NULL: a fall is
   DECID_BAD_INPUT, and sway_rad stays as it was. */
DECID_API decid_status decid_simulate(const decid_protocol* protocol, const double* parameters, size_t trials,
                                      uint64_t seed, double* sway_rad, unsigned char* valid);

/* ---- Models: a trained network and its settings ---- */

typedef struct decid_model decid_model;

/* A tensor of weights, or of BatchNorm's running statistics. */
typedef struct decid_tensor {
  const char* name; /* as in the file: "layers.0.weight" */
  const float* values;
  size_t dimensions;
  size_t shape[4]; /* row-major; convolutions (out, in, rows, columns) */
} decid_tensor;

typedef struct decid_layer {
  const char* text;                       /* "conv 64 3x3 stride 1x1 pad 1x1"; fused lines are joined by \n */
  size_t input_shape[3], output_shape[3]; /* channels, rows, columns */
  uint64_t flops;                         /* of one sample */
} decid_layer;

/* path: a model file of `decid train`; NULL: the built-in model. */
DECID_API decid_status decid_model_load(const char* path, decid_model** model);
DECID_API decid_status decid_model_save(const decid_model* model, const char* path); /* whole or not at all */
DECID_API void decid_model_free(decid_model* model);
DECID_API const decid_protocol* decid_model_protocol(const decid_model* model); /* do not free it */
DECID_API const char* decid_model_head(const decid_model* model);               /* the kind of outputs: "mixture 2" */
DECID_API const char* decid_model_sha256(const decid_model* model);             /* of the weights */
DECID_API size_t decid_model_layers(const decid_model* model);
DECID_API const decid_layer* decid_model_layer(const decid_model* model, size_t index);
DECID_API size_t decid_model_tensors(const decid_model* model);
DECID_API const decid_tensor* decid_model_tensor(const decid_model* model, size_t index);

/* ---- Recordings ---- */

typedef struct decid_recording decid_recording;

typedef enum decid_unit {
  DECID_BY_NAME = 0,
  DECID_DEGREES = 1,
  DECID_RADIANS = 2,
  DECID_MILLIRADIANS = 3,
  DECID_MILLIMETRES = 4, /* this and the next two: only for positions */
  DECID_CENTIMETRES = 5,
  DECID_METRES = 6
} decid_unit;

typedef struct decid_read_options {
  size_t size;
  const char* column;           /* of the sway, its name or its number from 1; NULL: found by name */
  int unit;                     /* a decid_unit; DECID_BY_NAME: from the column's name, else degrees */
  double rate_hz;               /* 0: from the column of time */
  double fill_gaps_s;           /* missing values up to this long, to 60, are interpolated; 0: refused */
  const char* tilt_column;      /* of the platform's measured tilt; NULL: found by name; "none": not read */
  int tilt_unit;                /* a decid_unit of angles; DECID_BY_NAME: from the name, else `unit`, else degrees */
  int invert_sway, invert_tilt; /* 1: positive against the protocol's direction */
  int skip_lines;               /* of a text file, above its table, 0 or more; -1: found [-1] */
  /* The sway's sources where there is no column of it (docs/guide/recordings.md, markers or segments); 0 and NULL:
   * none. */
  double com_height_m;                      /* `column` is a position at this height above the ankles */
  double body_height_m;                     /* of the person, for hip and shoulder, and to check com_height_m */
  const char *leg_column, *trunk_column;    /* angles in space */
  const char *hip_column, *shoulder_column; /* positions */
  const char* ankle_column;                 /* positions count from it; NULL: their means are upright */
  /* The table to read in a text file of several, by its name or its number from 1, or the sheet of a workbook by its
   * name; not with skip_lines. */
  const char* section;
  /* Where a file holds several recordings (docs/guide/recordings.md#several-recordings-in-one-file): the column that
     distinguishes them, several separated by commas, or an array of a MAT-file; "none": all rows are one recording;
     NULL: files of several are refused. */
  const char* trial_column;
  const char* trial;           /* the recording: a name of decid_trials_name; required with trial_column */
  const double* missing_value; /* a number that marks a missing value, in addition to the usual ones; NULL: none */
  int mean_is_upright; /* 1: detrend will subtract the sensor's offset, so the sway's size counts from its mean */
} decid_read_options;
DECID_API void decid_read_defaults(decid_read_options* options, size_t size);

/* The recordings of a file by options->trial_column, in the order in which they begin: "2", "s01,2"; the elements of an
   array are "1", "2", ... */
typedef struct decid_trials decid_trials;
DECID_API decid_status decid_trials_read(const char* path, const decid_read_options* options, decid_trials** trials);
DECID_API void decid_trials_free(decid_trials* trials);
DECID_API size_t decid_trials_count(const decid_trials* trials);
DECID_API const char* decid_trials_name(const decid_trials* trials, size_t index);

/* Reads a CSV, MAT, C3D or .xlsx file (docs/guide/recordings.md). If a centre of mass has several axes (COM_x, COM_y),
   decid_recording_sway gives the first, and decid_identify and decid_fit use the one that follows the tilt. */
DECID_API decid_status decid_recording_read(const char* path, const decid_read_options* options,
                                            decid_recording** recording);
/* Samples in memory, which are copied: sway of the body's centre of mass, 0 upright, positive in the platform's
   direction. unit: a decid_unit, DECID_BY_NAME is refused. Errors count samples from 1. */
DECID_API decid_status decid_recording_of(const double* sway, size_t samples, double rate_hz, int unit,
                                          decid_recording** recording);

typedef struct decid_samples_options {
  size_t size;
  int unit;                     /* of the sway: a decid_unit of angles. DECID_BY_NAME, the default, is refused */
  int tilt_unit;                /* as unit; DECID_BY_NAME: the sway's */
  const double* tilt;           /* of the platform, sampled with the sway: as many values; NULL: not measured */
  int invert_sway, invert_tilt; /* 1: positive against the protocol's direction of tilt */
  int mean_is_upright;          /* as in decid_read_options */
} decid_samples_options;
DECID_API void decid_samples_defaults(decid_samples_options* options, size_t size);

/* As decid_recording_of, with the platform's measured tilt. decid treats the tilt as a file's tilt_column: it
   determines where the protocol starts, and decid_identify and decid_fit compare its course, sign and size with the
   protocol's. */
DECID_API decid_status decid_recording_of_samples(const double* sway, size_t samples, double rate_hz,
                                                  const decid_samples_options* options, decid_recording** recording);
DECID_API void decid_recording_free(decid_recording* recording);
DECID_API size_t decid_recording_samples(const decid_recording* recording);
DECID_API double decid_recording_rate_hz(const decid_recording* recording);
DECID_API const double* decid_recording_sway(const decid_recording* recording); /* rad */
DECID_API const double* decid_recording_tilt(const decid_recording* recording); /* rad; NULL: not read */
DECID_API const char* decid_recording_column(const decid_recording* recording); /* of the sway; "" in memory */
DECID_API size_t decid_recording_warnings(const decid_recording* recording);
DECID_API const decid_warning* decid_recording_warning(const decid_recording* recording, size_t index);

/* ---- Identification ---- */

typedef struct decid_result decid_result;

typedef enum decid_detrend { DECID_DETREND_NONE = 0, DECID_DETREND_OFFSET = 1, DECID_DETREND_LINEAR = 2 } decid_detrend;

typedef struct decid_identify_options {
  size_t size;
  double mass_kg, height_m; /* of the person, both or none; 0: the protocol's body is assumed */
  double begin_s; /* where in the recording the protocol starts; NaN: at its first sample, or by its tilt [NaN] */
  int detrend;    /* a decid_detrend: subtract the mean of the whole cycles, or also a line [NONE] */
} decid_identify_options;
DECID_API void decid_identify_defaults(decid_identify_options* options, size_t size);

/* Estimates the parameters with the model's network, in milliseconds; `decid identify` gives the same bits. */
DECID_API decid_status decid_identify(const decid_model* model, const decid_recording* recording,
                                      const decid_identify_options* options, decid_result** result);

/* The prior of a parameter, in its unit, or over the body's m g h if the name ends in "/mgh": "Kp/mgh". A parameter may
   have two entries, one with its range and one with its normal prior: "Kp" in N m/rad and "Kp/mgh". */
typedef struct decid_parameter_prior {
  const char* name; /* as in decid_parameter; "/mgh" only if scales_with_mgh */
  double low, high; /* its range; both NaN: the model's */
  double mean, sd;  /* normal within the range; both NaN: uniform */
} decid_parameter_prior;

typedef struct decid_fit_options {
  size_t size;
  double mass_kg, height_m, begin_s; /* these and detrend: as in decid_identify_options */
  int detrend;
  const decid_protocol* protocol; /* the protocol played; NULL: the model's */
  double prior_start_s;           /* the recording starts within +- this of the protocol; 0: at it [0.1] */
  double prior_gain;              /* standard deviation of the logarithm of recorded over true sway; 0: known [0.06] */
  double prior_noise_deg;         /* centre of the measurement noise's prior, two thirds within a factor of 20 [0.02] */
  int max_draws;                  /* of each chain, 8 or more; fewer if they are enough [160] */
  uint64_t seed;                  /* [1] */
  decid_progress progress;        /* NULL: none */
  void* user;                     /* for progress */
  const decid_parameter_prior* parameter_priors; /* NULL: uniform in the ranges */
  size_t parameter_prior_count;
  int moved_before; /* 1: the platform played the cycle's end before the recording; 0: it rested, or the tilt decides */
  /* Names of decid_controller_name, separated by commas: each is fitted, decid_result_controller compares them, and the
     result is of the first one. NULL: the protocol's. A controller that the protocol names must be among them.
     parameter_priors act on the controllers that have the parameter. */
  const char* controllers;
} decid_fit_options;
DECID_API void decid_fit_defaults(decid_fit_options* options, size_t size);

/* Draws from the posterior, in seconds to minutes, as `decid fit`. If the chains are far apart, the result has the
   network's estimates (from_network of decid_sampling), unless a parameter has a prior, a range or a fixed value, as
   Kp of "dec2015" has. */
DECID_API decid_status decid_fit(const decid_model* model, const decid_recording* recording,
                                 const decid_fit_options* options, decid_result** result);

typedef enum decid_trust { DECID_USABLE = 0, DECID_WITH_CAUTION = 1, DECID_NOT_USABLE = 2 } decid_trust;

/* Unknown values are NaN. */
typedef struct decid_parameter {
  const char* name;
  const char* unit;
  double low, high; /* the range: of training, or the one that the fit's parameter_priors give */
  double value, sd;
  double interval50[2], interval90[2];
  double normalized, normalized_interval90[2]; /* over m g h */
  double rhat, effective_draws;                /* of a fit */
} decid_parameter;

typedef struct decid_figures {
  double rms_residual_deg, variance_accounted_for; /* the estimate's noise-free trial against the recording */
  double peak_to_peak_deg;
  double response_ratio;                            /* stimulus response ratio: 1 the whole response, 0 none */
  double ood_score;                                 /* out-of-distribution score; above 1: unlike the training trials */
  double tilt_delay_s, tilt_correlation, tilt_gain; /* of a measured tilt against the protocol's; NaN: unknown */
  double mass_kg, com_height_m, inertia_kgm2;       /* the body of stiffness and damping */
  int body_assumed;                                 /* 1: no mass and height were given */
} decid_figures;

/* A controller among those of decid_fit_options.controllers (docs/guide/fit.md, which controller). */
typedef struct decid_compared_controller {
  const char* controller;           /* its name */
  double log_predictive_density;    /* leave-one-out, nats */
  double difference;                /* of it to the largest one, nats: 0 or below */
  double difference_standard_error; /* 0 for that controller */
  double weight;                    /* stacking: the mixture with these weights predicts best; they add up to 1 */
  int comparable;                   /* 0: its chains are far apart or it has an invalid warning; ignore its numbers */
} decid_compared_controller;

typedef struct decid_sampling {
  int chains, draws; /* draws: of all chains */
  int agreed;        /* every R-hat is at most 1.05, and every quantity has 100 effective draws */
  int from_network;  /* 1: the chains are far apart, and the values are the network's */
  int divergences;
  double samples_noise_deg; /* white measurement noise, by the power above 2 Hz */
  double seconds;
} decid_sampling;

DECID_API void decid_result_free(decid_result* result);
DECID_API decid_trust decid_result_trust(const decid_result* result); /* of NULL: DECID_NOT_USABLE */
DECID_API size_t decid_result_parameters(const decid_result* result);
/* A fit's parameters are followed by three more quantities: sensor_noise_deg, start_s and gain. */
DECID_API size_t decid_result_quantities(const decid_result* result);
DECID_API const decid_parameter* decid_result_parameter(const decid_result* result, size_t index);
/* Returns NaN if it is not known. */
DECID_API double decid_result_correlation(const decid_result* result, size_t a, size_t b);
DECID_API const decid_figures* decid_result_figures(const decid_result* result);
DECID_API size_t decid_result_warnings(const decid_result* result);
DECID_API const decid_warning* decid_result_warning(const decid_result* result,
                                                    size_t index); /* the most severe first */
/* The recording at the protocol's rate and length, and the estimate's noise-free trial, which is shorter if the body
   falls; rad. samples: their number; may be NULL. */
DECID_API const float* decid_result_sway(const decid_result* result, size_t* samples);
DECID_API const float* decid_result_fitted(const decid_result* result, size_t* samples);
/* Returns NULL unless the result is a fit's. */
DECID_API const decid_sampling* decid_result_sampling(const decid_result* result);
/* A quantity's draws, chain by chain: decid_sampling.draws values. */
DECID_API const double* decid_result_draws(const decid_result* result, size_t quantity);
/* The controllers that were fitted, in the order of the options; 0 unless they were several. */
DECID_API size_t decid_result_controllers(const decid_result* result);
DECID_API const decid_compared_controller* decid_result_controller(const decid_result* result, size_t index);

/* ---- Studies: the recordings of a sheet, and the comparison of their participants ---- */

typedef struct decid_study decid_study;

typedef struct decid_study_options {
  size_t size;
  int by_group;       /* 1: compare the groups in the sheet's column "group" */
  const char* within; /* "session", "condition" or "session,condition": compare them within participants; NULL: none */
  const char* covariates; /* columns of numbers, such as "age,weight"; NULL: none */
  int fit;                /* 1: sample posteriors, as `decid fit`; 0: as `decid identify` */
  const char* joint;      /* of fits: fit recordings together that have the same text in this column; NULL: none */
  const char* free;       /* with joint: parameters that differ between the texts of a column, "theta,Nv:condition" */
  int max_draws;          /* of fits, as in decid_fit_options; these four [160] */
  uint64_t seed;          /* [1] */
  decid_progress progress;
  void* user;
  const char* controllers; /* of fits, as in decid_fit_options; not several with joint */
} decid_study_options;
DECID_API void decid_study_defaults(decid_study_options* options, size_t size);

/* Reads a sheet (docs/guide/studies.md) and the recordings that it names, and estimates each, with its own body,
   protocol and options: the bits of `decid identify --study` and `decid fit --study`. A recording that cannot be used
   has an error in the JSON. */
DECID_API decid_status decid_study_run(const decid_model* model, const char* sheet, const decid_study_options* options,
                                       decid_study** study);
DECID_API void decid_study_free(decid_study* study);
/* The JSON of these commands (docs/guide/results.md), with the groups (docs/guide/groups.md), for `decid rerun`. */
DECID_API const char* decid_study_json(const decid_study* study);

/* ---- Data sets: simulated trials of known parameters ---- */

typedef struct decid_dataset decid_dataset;

typedef struct decid_dataset_options {
  size_t size;
  int count;        /* valid trials in all */
  int base;         /* number of trials drawn from the ranges; the rest are children of large sways. 0: all */
  uint64_t seed;    /* [1] */
  const char* path; /* NULL: in memory; else an .npz file, made as `decid dataset` does and not read into memory */
  decid_progress progress;
  void* user;
} decid_dataset_options;
DECID_API void decid_dataset_defaults(decid_dataset_options* options, size_t size);

/* The bytes depend only on protocol, count, base and seed. */
DECID_API decid_status decid_dataset_make(const decid_protocol* protocol, const decid_dataset_options* options,
                                          decid_dataset** dataset);
DECID_API decid_status decid_dataset_read(const char* path, decid_dataset** dataset);       /* its sway stays on disk */
DECID_API decid_status decid_dataset_write(const decid_dataset* dataset, const char* path); /* of one in memory */
DECID_API void decid_dataset_free(decid_dataset* dataset);
DECID_API size_t decid_dataset_trials(const decid_dataset* dataset);
DECID_API const decid_protocol* decid_dataset_protocol(
    const decid_dataset* dataset); /* belongs to the data set: do not free it */
DECID_API const double* decid_dataset_parameters(const decid_dataset* dataset); /* trials x parameters, SI units */
DECID_API const int32_t* decid_dataset_group(const decid_dataset* dataset);     /* the trial's parent, or itself */
DECID_API const uint8_t* decid_dataset_split(const decid_dataset* dataset);     /* 0 training, 1 validation */
/* trials x samples, rad; NULL if it stays on disk. */
DECID_API const float* decid_dataset_sway(const decid_dataset* dataset);
/* Copies the sway of trials first .. first + trials - 1, rad. If it fails, it may have written some of the rows. */
DECID_API decid_status decid_dataset_copy_sway(const decid_dataset* dataset, size_t first, size_t trials,
                                               float* sway_rad);

/* ---- Evaluation and training ---- */

#define DECID_MAX_PARAMETERS 32

/* Errors of z-scored parameters: guessing the mean has an error of 1. NaN where the model gives no distribution. */
typedef struct decid_evaluation {
  size_t trials;
  double mse, matlab_loss;
  double mse_per_parameter[DECID_MAX_PARAMETERS];
  double coverage50, coverage90; /* fraction of the true values in the intervals */
  double log_score;              /* nats per parameter; 0: only the ranges are known */
} decid_evaluation;

typedef enum decid_split { DECID_ALL = 0, DECID_TRAINING = 1, DECID_VALIDATION = 2 } decid_split;

/* Measures the model's error on trials. Training trials are refused, except that each half of the model's own data set
   is allowed. split: a decid_split; size: sizeof(decid_evaluation). */
DECID_API decid_status decid_evaluate(const decid_model* model, const decid_dataset* dataset, int split,
                                      decid_evaluation* evaluation, size_t size);

/* Progress of a training. */
typedef struct decid_training {
  int epoch, epochs; /* epoch: the current one, from 1 */
  int done, trials;  /* of the epoch's trials */
  int epoch_is_over; /* 1: the three below are known, else NaN */
  double training_mse, validation_mse, learning_rate;
} decid_training;
/* Called after each batch and each epoch's validation. As decid_progress, but always from the caller's thread. */
typedef int (*decid_training_progress)(void* user, const decid_training* training);

/* NULL, 0 and -1 mean the preset's value, unless a comment gives another meaning. */
typedef struct decid_train_options {
  size_t size;
  const char* preset;                   /* docs/guide/models.md lists them; NULL: "best" ["best"] */
  const char* architecture;             /* layers, one per line */
  const char* head;                     /* "point", "mixture 2" */
  const char* image;                    /* JSON of image settings */
  const char* schedule;                 /* "constant", "cosine", "step:EPOCHS:FACTOR" */
  int epochs, batch;                    /* [0] */
  double learning_rate;                 /* [0] */
  double momentum, weight_decay;        /* [-1] */
  uint64_t seed;                        /* of weights, shuffling and a protocol's trials [1] */
  int patience;                         /* epochs without improvement before it stops and keeps the best; 0: never */
  int stream_trials, validation_trials; /* with a protocol: trials per epoch [25600], for validation [1000] */
  decid_training_progress progress;
  void* user;
} decid_train_options;
DECID_API void decid_train_defaults(decid_train_options* options, size_t size);

/* Trains a model on a data set, or on new trials of a protocol in every epoch: give one of the two, NULL for the other.
   `decid train` with these settings gives the same weights and writes checkpoints; use it for long trainings. */
DECID_API decid_status decid_train(const decid_dataset* dataset, const decid_protocol* protocol,
                                   const decid_train_options* options, decid_model** model);

#ifdef __cplusplus
}
#endif

#endif /* DECID_H */
