// Results of `decid study` about a model: the figures of the paper's results section, and the errors of its estimates
// at stated levels of measurement noise. Computed here; tools/report/figures/study_figures.hpp draws it, study_page.hpp
// reports it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dataset/npz/npz.hpp"
#include "identify/evaluation/comparison.hpp"
#include "identify/evaluation/faults.hpp"
#include "identify/recordings.hpp"
#include "identify/training/training.hpp"

namespace decid {

/// The z-scored values of a set of parameters.
using Scores = std::vector<double>;

/// A trial with known parameters, identified, and simulated again from its estimate.
struct KnownTrial {
  sim::Parameters truth, identified;
  Scores target, output;
  std::vector<float> sway_rad;
  std::vector<float> fitted_rad;  ///< the single pendulum, noise-free; shorter if it fell over
  double peak_to_peak_rad = 0.0;
  /// Returns the sum of the squared z-scored errors: our reading of the paper's "SE".
  double squared_error() const;
};

/// An example: the trial of a set with the median squared error, so that it is not hand-picked.
struct Sample {
  std::string from;  ///< "validation half", "test trials"
  int index = 0;     ///< among these
  KnownTrial trial;
  std::vector<float> image;  ///< before row scaling
  dataset::ImageShape image_shape{};
  std::vector<float> activation;  ///< of the network's first layer, BatchNorm included, before ReLU
  nn::Shape activation_shape{};
  std::string activation_layer;
};

struct StudyData {
  std::string file;
  std::uint64_t seed = 0;
  int base = 0;                             ///< trials before enrichment
  Evaluation training, validation;          ///< both in inference, with the finished model
  dataset::TrialDistributions before, all;  ///< of enrichment; peak to peak as stored
};

/// The double inverted pendulum with default parameters: the parameters of its ankle against the identified ones.
struct DoubleCase {
  KnownTrial trial;                    ///< of noise realisation 0; truth: the ankle's parameters
  std::vector<double> squared_errors;  ///< of each realisation that stood
};

/// Trials with low <= x < high. NaN without trials.
struct Bin {
  double low, high;
  int trials = 0;
  Scores mse;       ///< z-scored, of each parameter
  Scores baseline;  ///< of the training set's mean instead of the network
};
struct NoiseLevel {
  double sensor_noise_deg;
  Evaluation all;
  std::vector<Bin> by_amplitude_deg;  ///< peak to peak of the noise-free sway
  std::vector<Bin> by_nv;
};

struct LearningPoint {
  double trials, mse;
};

struct ModelStudy {
  std::string model, sha256, version;
  Origin origin;  ///< the model's
  sim::Protocol protocol;
  sim::Parameters target_stddev;  ///< standard deviations of the model's z-scores, SI units
  dataset::ImageSettings image;
  std::size_t network_parameters = 0;
  std::string architecture;
  std::vector<EpochLog> log;  ///< of the training; may be empty
  std::optional<StudyData> data;
  Sample sample;
  std::optional<DoubleCase> dip;
  std::optional<RecordingResult> recording;
  Scores recording_output;
  std::vector<NoiseLevel> levels;
  double faults_noise_deg = 0.02;    ///< measurement noise of the trials with faults
  std::vector<FaultFigures> faults;  ///< identify/evaluation/faults.hpp; empty unless asked for
  std::uint64_t fresh_seed = 99;     ///< to be set before anything is computed
  std::vector<LearningPoint> learning_curve;
  std::vector<ComparisonFigures> comparisons;           ///< of this model
  std::vector<std::pair<std::string, double>> seconds;  ///< what took how long, as given on the command line
  std::vector<std::string> notes;                       ///< what is missing, and why
};

/// Called with the name of the next step.
using Announce = std::function<void(const std::string&)>;

/// Computes `data` and `sample`. Throws Error if the data set is of another experiment than the model, or of the seed
/// `fresh_seed`.
void study_dataset(const Model& model, const std::string& file, ModelStudy& study, const Announce& announce);

/// Computes `levels`, on `trials` valid base trials of `fresh_seed`, the same at each level; computes `sample` if it is
/// missing. Throws Error if the model was trained on trials of that seed.
void study_fresh(const Model& model, int trials, const std::vector<double>& levels_deg, ModelStudy& study,
                 const Announce& announce);

/// Computes `dip`, or adds a note if the model's body is not made of segments.
void study_double(const Model& model, int realisations, ModelStudy& study, const Announce& announce);

/// Reads a table with columns trials and mse, more trials from row to row.
std::vector<LearningPoint> read_learning_curve(const std::string& file);
/// Reads the log that decid train writes next to a model.
std::vector<EpochLog> read_log(const std::string& file);

}  // namespace decid
