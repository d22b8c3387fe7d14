// Faults of recordings: see faults.hpp.
#include "identify/evaluation/faults.hpp"

#include <algorithm>
#include <limits>
#include <optional>

#include "base/parallel.hpp"
#include "base/text.hpp"
#include "identify/evaluation/fault_trials.hpp"
#include "identify/identify.hpp"
#include "identify/network/prediction.hpp"

namespace decid {
namespace {

/// Trials that are simulated and judged together: 25 MB of the default protocol's.
constexpr int faults_at_once = 512;

/// A row while its trials are judged.
struct Row {
  std::vector<float> scores;
  std::vector<sim::Parameters> truth;
  std::vector<CalibratedTrial> predictions;
  int trials = 0, warned = 0;
};

void judge(const Identifier& identifier, FaultTrials::Trials trials, Row& row) {
  constexpr std::size_t group_size = 64;
  const Model& model = identifier.model();
  const std::size_t count = trials.sways.size();
  std::vector<sim::Parameters> found(count);
  std::vector<std::optional<CalibratedTrial>> predictions(count);
  std::vector<char> warned(count);  // bytes, which threads may write side by side
  parallel_for(static_cast<int>((count + group_size - 1) / group_size), [&](int group) {
    Identifier own(identifier);
    const std::size_t first = static_cast<std::size_t>(group) * group_size, end = std::min(count, first + group_size);
    const auto at = [&](std::size_t i) { return trials.sways.begin() + static_cast<std::ptrdiff_t>(i); };
    const std::vector<recording::Trial> sways(std::make_move_iterator(at(first)), std::make_move_iterator(at(end)));
    const std::vector<Estimate> estimates = own.estimate(sways);
    const std::vector<Explanation> explanations = own.explain(estimates, sways);
    for (std::size_t k = 0; k < estimates.size(); ++k) {
      const std::size_t i = first + k;
      found[i] = estimates[k].parameters;
      warned[i] = worst_trust(trials.warnings[i]) != Trust::usable ||
                  worst_trust(estimates[k].warnings) != Trust::usable ||
                  worst_trust(explanations[k].warnings) != Trust::usable;
      if (estimates[k].distribution && !trials.truth.empty())
        predictions[i] = calibrate(trials.truth[i], *estimates[k].distribution);
    }
  });
  row.trials += static_cast<int>(count);
  row.warned += static_cast<int>(std::ranges::count(warned, 1));
  for (std::size_t i = 0; i < trials.truth.size(); ++i) {
    const std::vector<float> own = model.targets.scale(found[i]);
    row.scores.insert(row.scores.end(), own.begin(), own.end());
    if (predictions[i]) row.predictions.push_back(std::move(*predictions[i]));
  }
  row.truth.insert(row.truth.end(), trials.truth.begin(), trials.truth.end());
}

FaultFigures figures(const Model& model, const Fault& fault, const Row& row) {
  FaultFigures made{fault, {}, {}, static_cast<double>(row.warned) / row.trials};
  if (row.truth.empty()) {
    made.errors.trials = row.trials;
    made.errors.mse_per_parameter.assign(model.parameters().size(), std::numeric_limits<double>::quiet_NaN());
    return made;
  }
  made.errors = evaluate(model.targets, row.scores, row.truth);
  if (!row.predictions.empty()) made.calibration = compute_calibration(row.predictions, model.targets.stddev);
  return made;
}

}  // namespace

FaultStudy study_faults(const Model& model, double sensor_noise_deg, int trials, std::uint64_t seed,
                        const std::function<void(const std::string&)>& announce) {
  require_not_trained_on(model.origin, {dataset::TrialIdentity::Kind::stream, seed, {}}, Measured::all, "test trials");
  sim::Protocol protocol = model.protocol.ideal();
  protocol.noise.sensor = {sensor_noise_deg, sensor_noise_deg};
  const Identifier identifier(model);
  FaultStudy study;
  for (const Fault& fault : all_faults()) {
    std::string missing = impossible(protocol, fault);
    std::optional<FaultTrials> source;
    std::optional<sim::Protocol> recorded;
    Row row;
    // A tilt that is too large, a body without segments, a controller that falls.
    try {
      if (missing.empty()) {
        recorded = with_fault(protocol, fault);
        source.emplace(protocol, *recorded, fault, seed);
      }
      for (int first = 0; source && first < trials; first += faults_at_once) {
        const int count = std::min(faults_at_once, trials - first);
        announce(format("trials %d to %d of %d, %s", first + 1, first + count, trials, fault.text.c_str()));
        judge(identifier, source->take(first, count), row);
      }
    } catch (const Error& error) {
      if (fault.name != "tilt" && fault.name != "double_pendulum") throw;
      missing = error.what();
    }
    if (missing.empty() && row.trials == 0) missing = "none of its trials stands";
    if (missing.empty())
      study.rows.push_back(figures(model, fault, row));
    else
      study.notes.push_back("no row of recordings " + fault.text + ": " + missing);
  }
  return study;
}

}  // namespace decid
