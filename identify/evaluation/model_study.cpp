// The computations of decid study: see model_study.hpp.
#include "identify/evaluation/model_study.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/parallel.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "identify/explanation.hpp"
#include "identify/network/prediction.hpp"
#include "nn/predictor.hpp"
#include "recording/formats/csv.hpp"
#include "sim/double_pendulum.hpp"
#include "sim/streams.hpp"

namespace decid {
namespace {

using dataset::Part;

double peak_to_peak(std::span<const float> sway_rad) {
  const auto [low, high] = std::ranges::minmax(sway_rad);
  return static_cast<double>(high) - static_cast<double>(low);
}

Scores as_scores(std::span<const float> values) {
  return {values.begin(), values.end()};
}

/// Returns the scores of trial `index`.
std::span<const float> scores_at(const Model& model, const std::vector<float>& scores, std::size_t index) {
  return std::span(scores).subspan(index * model.parameters().size(), model.parameters().size());
}

KnownTrial known_trial(const Model& model, const sim::Simulator& simulator, const sim::Parameters& truth,
                       std::span<const float> scores, std::vector<float> sway_rad) {
  KnownTrial trial;
  trial.truth = truth;
  trial.identified = model.targets.unscale(scores);
  trial.target = as_scores(model.targets.scale(truth));
  trial.output = as_scores(scores);
  trial.fitted_rad = noise_free_trial(simulator, trial.identified);
  trial.peak_to_peak_rad = peak_to_peak(sway_rad);
  trial.sway_rad = std::move(sway_rad);
  return trial;
}

/// The trial with the median of the squared errors.
int typical(const Model& model, const std::vector<float>& scores, const std::vector<sim::Parameters>& truth) {
  std::vector<std::pair<double, int>> errors;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto target = model.targets.scale(truth[i]);
    const std::span<const float> found = scores_at(model, scores, i);
    double sum = 0;
    for (std::size_t p = 0; p < target.size(); ++p) {
      const double error = static_cast<double>(found[p]) - static_cast<double>(target[p]);
      sum += error * error;
    }
    errors.emplace_back(sum, static_cast<int>(i));
  }
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>((errors.size() - 1) / 2);
  std::ranges::nth_element(errors, middle);
  return middle->second;
}

Sample make_sample(const Model& model, std::string from, int index, KnownTrial trial) {
  Sample sample{std::move(from), index, std::move(trial), {}, model.images().shape(), {}, {}, {}};
  sample.image.resize(static_cast<std::size_t>(sample.image_shape.size()));
  model.images().make(sample.trial.sway_rad, sample.image);
  std::vector<float> input = sample.image;
  model.scale(input);
  const nn::Layer<float>& first = model.network.layers().front();
  sample.activation_shape = first.dst_shape();
  sample.activation_layer = first.text();
  sample.activation.resize(static_cast<std::size_t>(sample.activation_shape.size()));
  nn::Predictor(model.network, 1).activation(0, input, sample.activation);
  return sample;
}

std::vector<Bin> bins(const std::vector<double>& edges, std::size_t parameters) {
  std::vector<Bin> made;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i)
    made.push_back({edges[i], edges[i + 1], 0, Scores(parameters), Scores(parameters)});
  return made;
}

void add(std::vector<Bin>& all, double x, const Scores& target, const Scores& output) {
  for (Bin& bin : all) {
    // The last bin has its upper end.
    if (x < bin.low || x > bin.high || (x == bin.high && &bin != &all.back())) continue;
    ++bin.trials;
    for (std::size_t p = 0; p < target.size(); ++p) {
      bin.mse[p] += (output[p] - target[p]) * (output[p] - target[p]);
      bin.baseline[p] += target[p] * target[p];
    }
    return;
  }
}

void finish(std::vector<Bin>& all) {
  for (Bin& bin : all)
    for (std::size_t p = 0; p < bin.mse.size(); ++p) {
      const double count = bin.trials > 0 ? bin.trials : std::numeric_limits<double>::quiet_NaN();
      bin.mse[p] /= count;
      bin.baseline[p] /= count;
    }
}

/// Test trials of a stream. The sways of one chunk of them are in memory.
class TestTrials {
 public:
  TestTrials(const sim::Simulator& simulator, std::uint64_t seed, int trials)
      : simulator_(simulator),
        seed_(seed),
        truth_(static_cast<std::size_t>(trials)),
        amplitude_deg_(static_cast<std::size_t>(trials)) {}

  void simulate(int first, int count) {
    first_ = first;
    sways_.assign(static_cast<std::size_t>(count), {});
    std::vector<std::uint64_t> numbers(sways_.size());
    std::iota(numbers.begin(), numbers.end(), static_cast<std::uint64_t>(first));
    dataset::simulate_stream(simulator_, seed_, numbers,
                             [&](std::size_t place, const sim::TrialInput& trial, std::span<double> sway) {
                               const std::size_t at = static_cast<std::size_t>(first) + place;
                               const auto [low, high] = std::ranges::minmax(sway);
                               truth_[at] = trial.parameters;
                               amplitude_deg_[at] = (high - low) / sim::rad_per_deg;
                               sways_[place].assign(sway.begin(), sway.end());
                             });
  }

  /// Returns the sway of a trial of the chunk with measurement noise.
  std::vector<float> noisy(int trial, double level_deg) const {
    std::vector<double> sway = sways_[static_cast<std::size_t>(trial - first_)];
    sim::add_sensor_noise({level_deg, level_deg}, seed_, static_cast<std::uint64_t>(trial), sway);
    return {sway.begin(), sway.end()};
  }

  // Per trial that was simulated:
  const std::vector<sim::Parameters>& truth() const { return truth_; }
  const std::vector<double>& amplitude_deg() const { return amplitude_deg_; }  ///< peak to peak

 private:
  const sim::Simulator& simulator_;
  std::uint64_t seed_;
  int first_ = 0;  ///< trial of the chunk
  std::vector<sim::Parameters> truth_;
  std::vector<double> amplitude_deg_;
  std::vector<std::vector<double>> sways_;
};

/// Returns the errors at a level of measurement noise.
NoiseLevel noise_level(const Model& model, double level_deg, const TestTrials& test, const std::vector<float>& scores) {
  const std::size_t parameters = model.parameters().size();
  NoiseLevel level{level_deg, evaluate(model.targets, scores, test.truth()),
                   bins({0, 0.5, 1, 1.5, 2, 3, 4, 6, 10}, parameters),
                   bins({0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1}, parameters)};
  for (std::size_t i = 0; i < test.truth().size(); ++i) {
    const sim::Parameters& truth = test.truth()[i];
    const Scores target = as_scores(model.targets.scale(truth));
    const Scores output = as_scores(scores_at(model, scores, i));
    add(level.by_amplitude_deg, test.amplitude_deg()[i], target, output);
    add(level.by_nv, model.protocol.family().coefficients(truth)[sim::Coefficient::nv], target, output);
  }
  finish(level.by_amplitude_deg);
  finish(level.by_nv);
  return level;
}

int column_named(const recording::CsvTable& table, const std::string& name, const std::string& file) {
  for (int c = 0; c < table.columns(); ++c)
    if (table.names()[static_cast<std::size_t>(c)] == name) return c;
  throw Error(Code::column_missing, file, "has no column '" + name + "'", "give a table whose header has it");
}

}  // namespace

double KnownTrial::squared_error() const {
  double sum = 0;
  for (std::size_t p = 0; p < target.size(); ++p) sum += (output[p] - target[p]) * (output[p] - target[p]);
  return sum;
}

void study_dataset(const Model& model, const std::string& file, ModelStudy& study, const Announce& announce) {
  const dataset::StoredDataset stored{std::filesystem::path(file)};
  const dataset::Dataset& about = stored.about();
  require_same_experiment(model, study.model, about.protocol, file);
  if (about.seed == study.fresh_seed)
    throw Error(Code::data_reused, "test trials", "the model was trained with seed " + std::to_string(about.seed),
                "give another " + setting("seed"));
  announce("sway of " + file);
  StudyData& data = study.data.emplace();
  data.file = file;
  data.seed = about.seed;
  data.before = data.all = dataset::TrialDistributions(model.parameters());
  std::vector<double> amplitude(static_cast<std::size_t>(stored.trials()));
  stored.take(0, stored.trials(),
              [&](std::size_t i, std::span<const float> sway) { amplitude[i] = peak_to_peak(sway); });
  for (std::size_t i = 0; i < amplitude.size(); ++i) {
    const bool base = about.group[i] == static_cast<std::int32_t>(i);
    if (base) data.before.add(about.parameters[i], amplitude[i]);
    data.base += base ? 1 : 0;
    data.all.add(about.parameters[i], amplitude[i]);
  }

  const auto source = dataset::stored_source(stored);
  announce(format("identifying %d training trials", source->trials(Part::training)));
  const Predicted training = predict(model, *source, Part::training);
  data.training = evaluate(model.targets, training.scores, training.truth);
  announce(format("identifying %d validation trials", source->trials(Part::validation)));
  const Predicted validation = predict(model, *source, Part::validation);
  data.validation = evaluate(model.targets, validation.scores, validation.truth);

  const int index = typical(model, validation.scores, validation.truth);
  const auto place = static_cast<std::size_t>(index);
  std::vector<float> sway;
  source->take(
      Part::validation, 0, std::vector<int>{index},
      [&](std::size_t, const sim::Parameters&, const dataset::Sway& of) { sway.assign(of.rad.begin(), of.rad.end()); });
  study.sample = make_sample(model, "validation half", index,
                             known_trial(model, sim::Simulator(model.protocol), validation.truth[place],
                                         scores_at(model, validation.scores, place), sway));
}

void study_fresh(const Model& model, int trials, const std::vector<double>& levels_deg, ModelStudy& study,
                 const Announce& announce) {
  constexpr int chunk = 512;
  const std::uint64_t seed = study.fresh_seed;
  require_not_trained_on(model.origin, {dataset::TrialIdentity::Kind::stream, seed, {}}, Measured::all, "test trials");
  const sim::Simulator simulator(model.protocol.ideal());
  TestTrials test(simulator, seed, trials);
  std::vector<std::vector<float>> scores(levels_deg.size());
  for (int first = 0; first < trials; first += chunk) {
    const int count = std::min(chunk, trials - first);
    announce(format("test trials %d to %d of %d at %zu levels of measurement noise", first + 1, first + count, trials,
                    levels_deg.size()));
    test.simulate(first, count);
    for (std::size_t l = 0; l < levels_deg.size(); ++l) {
      const auto outputs = predict(model, count, 64, [&](std::span<const int> indices, const SwaySink& take) {
        parallel_for(static_cast<int>(indices.size()), [&](int place) {
          take(static_cast<std::size_t>(place),
               test.noisy(first + indices[static_cast<std::size_t>(place)], levels_deg[l]));
        });
      });
      const std::vector<float> of_chunk = to_scores(model, outputs);
      scores[l].insert(scores[l].end(), of_chunk.begin(), of_chunk.end());
    }
  }
  for (std::size_t l = 0; l < levels_deg.size(); ++l)
    study.levels.push_back(noise_level(model, levels_deg[l], test, scores[l]));
  if (study.data) return;
  const int index = typical(model, scores.front(), test.truth());
  const auto place = static_cast<std::size_t>(index);
  const int first = index / chunk * chunk;
  test.simulate(first, std::min(chunk, trials - first));
  study.sample =
      make_sample(model, format("test trials with %g degrees of measurement noise", levels_deg.front()), index,
                  known_trial(model, simulator, test.truth()[place], scores_at(model, scores.front(), place),
                              test.noisy(index, levels_deg.front())));
}

void study_double(const Model& model, int realisations, ModelStudy& study, const Announce& announce) {
  if (model.protocol.experiment.body_model != &sim::single_pendulum()) {
    study.notes.push_back("no double pendulum: its joints have the controller dec, the model has " +
                          model.protocol.experiment.body_model->name);
    return;
  }
  announce("leg and trunk");
  std::optional<sim::DoubleSimulator> simulator;
  try {
    simulator.emplace(model.protocol);
  } catch (const Error& error) {
    study.notes.push_back(std::string("no double pendulum: ") + error.what());
    return;
  }
  const sim::DoubleParameters parameters = sim::default_double_parameters(simulator->segments());
  const auto samples = static_cast<std::size_t>(simulator->samples());
  std::vector<std::vector<float>> sways;
  std::vector<double> com(samples), leg(samples), trunk(samples);
  for (int r = 0; r < realisations; ++r) {
    const Random noise(study.fresh_seed, sim::streams::vestibular_noise, static_cast<std::uint64_t>(r));
    if (simulator->run(parameters, noise, {com, leg, trunk}).valid) sways.emplace_back(com.begin(), com.end());
  }
  if (sways.empty()) {
    study.notes.emplace_back("no double pendulum: with this protocol none of its trials stands");
    return;
  }
  const auto outputs =
      predict(model, static_cast<int>(sways.size()), 64,
              sways_in_memory([&](int i) { return std::span<const float>(sways[static_cast<std::size_t>(i)]); }));
  const std::vector<float> scores = to_scores(model, outputs);
  const sim::Simulator single(model.protocol);
  DoubleCase& dip = study.dip.emplace();
  for (std::size_t i = 0; i < sways.size(); ++i) {
    KnownTrial trial = known_trial(model, single, parameters.ankle, scores_at(model, scores, i), sways[i]);
    dip.squared_errors.push_back(trial.squared_error());
    if (i == 0) dip.trial = std::move(trial);
  }
}

std::vector<LearningPoint> read_learning_curve(const std::string& file) {
  const recording::CsvTable table(read_file(file, std::size_t{1} << 24), file);
  recording::require_whole(table, file);
  const auto trials = table.numbers(column_named(table, "trials", file));
  const auto mse = table.numbers(column_named(table, "mse", file));
  std::vector<LearningPoint> curve;
  for (std::size_t i = 0; i < trials.size(); ++i) {
    if (!(trials[i] > (i > 0 ? trials[i - 1] : 0)) || !(mse[i] >= 0))
      throw Error(Code::value_invalid, file,
                  format("%s: trials must grow from row to row, and no mse be negative", table.locate(i).c_str()),
                  "sort it by trials");
    curve.push_back({trials[i], mse[i]});
  }
  return curve;
}

std::vector<EpochLog> read_log(const std::string& file) {
  const recording::CsvTable table(read_file(file, std::size_t{1} << 26), file);
  const auto epoch = table.numbers(column_named(table, "epoch", file));
  const auto training = table.numbers(column_named(table, "training_mse", file));
  const auto validation = table.numbers(column_named(table, "validation_mse", file));
  const auto rate = table.numbers(column_named(table, "learning_rate", file));
  std::vector<EpochLog> log;
  for (std::size_t i = 0; i < epoch.size(); ++i) {
    log.push_back({static_cast<int>(i) + 1, training[i], validation[i], rate[i]});
    if (epoch[i] != static_cast<double>(i + 1))
      throw Error(Code::value_invalid, file, format("%s: epochs do not count from 1", table.locate(i).c_str()),
                  "give the log that decid train wrote");
  }
  return log;
}

}  // namespace decid
