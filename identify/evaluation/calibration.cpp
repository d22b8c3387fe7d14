// Simulation-based calibration: see calibration.hpp.
#include "identify/evaluation/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"

namespace decid {
namespace {

constexpr double kolmogorov_95 = 1.36, chance = 0.05;
constexpr double fixed_sd =
    1e-9;  // of a parameter that is fixed, from rounding; over its range, or the range's standard deviation

/// The largest distance of the empirical distribution of values in [0, 1] from the uniform one.
double distance_from_uniform(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto count = static_cast<double>(values.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto before = static_cast<double>(i);
    largest = std::max({largest, values[i] - before / count, (before + 1.0) / count - values[i]});
  }
  return largest;
}

/// Returns a trial without `below` and without the fields of chains.
template <class Found>
CalibratedTrial beside(const sim::Parameters& truth, const Found& found) {
  CalibratedTrial trial;
  trial.truth = truth;
  trial.mean = trial.stddev = sim::Parameters(truth.size());
  for (std::size_t p = 0; p < truth.size(); ++p) {
    trial.mean[p] = found.mean(static_cast<int>(p));
    trial.stddev[p] = found.stddev(static_cast<int>(p));
  }
  return trial;
}

}  // namespace

double gaussian_log_score(const sim::Parameters& truth, std::span<const posterior::State> draws,
                          const sim::ParameterTable& ranges) {
  const auto fraction = [&](std::size_t p, double value) { return (value - ranges[p].low) / ranges[p].range(); };
  std::vector<std::size_t> inferred;
  for (std::size_t p = 0; p < ranges.size() && !draws.empty(); ++p) {
    const auto [low, high] = std::ranges::minmax(draws, {}, [p](const posterior::State& d) { return d.parameters[p]; });
    if (high.parameters[p] - low.parameters[p] > fixed_sd * ranges[p].range()) inferred.push_back(p);
  }
  const std::size_t parameters = inferred.size();
  if (parameters == 0) return CalibratedTrial::unknown_score;
  const auto count = static_cast<double>(draws.size());
  std::vector<double> centre(parameters), covariance(triangle(parameters)), x(parameters);
  const auto each_draw = [&](const auto& body) {
    for (const posterior::State& draw : draws) {
      for (std::size_t p = 0; p < parameters; ++p)
        x[p] = mixture_coordinate(fraction(inferred[p], draw.parameters[inferred[p]]));
      body();
    }
  };
  each_draw([&] {
    for (std::size_t p = 0; p < parameters; ++p) centre[p] += x[p] / count;
  });
  each_draw([&] {
    for (std::size_t p = 0; p < parameters; ++p)
      for (std::size_t q = 0; q <= p; ++q)
        covariance[triangle(p) + q] += (x[p] - centre[p]) * (x[q] - centre[q]) / (count - 1.0);
  });
  if (!factorize(parameters, covariance)) return CalibratedTrial::unknown_score;
  invert_lower(parameters, covariance);  // A: A (x - centre) is standard normal
  for (std::size_t p = 0; p < parameters; ++p) x[p] = mixture_coordinate(fraction(inferred[p], truth[inferred[p]]));
  double sum = 0.0;
  for (std::size_t p = 0; p < parameters; ++p) {
    const double* const row = covariance.data() + triangle(p);
    double y = 0.0;
    for (std::size_t q = 0; q <= p; ++q) y += row[q] * (x[q] - centre[q]);
    sum += decid::log(row[p]) + 0.5 * (x[p] * x[p] - y * y);  // over the density of x beforehand, standard normal
  }
  return sum / static_cast<double>(parameters);
}

CalibratedTrial calibrate(const sim::Parameters& truth, std::span<const posterior::Posterior> of_trials,
                          const sim::ParameterTable& ranges) {
  const posterior::Posterior& found = of_trials.front();
  CalibratedTrial trial = beside(truth, found);
  for (std::size_t p = 0; p < truth.size(); ++p) {
    const auto below = std::ranges::count_if(
        found.states(), [&](const posterior::State& state) { return state.parameters[p] < truth[p]; });
    trial.below.push_back(static_cast<double>(below) / found.draws());
  }
  trial.effective_draws = std::numeric_limits<double>::infinity();
  for (const posterior::Posterior& each : of_trials) {
    trial.rhat = std::max(trial.rhat, *std::ranges::max_element(each.rhat()));
    trial.effective_draws = std::min(trial.effective_draws, *std::ranges::min_element(each.effective_draws()));
  }
  trial.agreed = std::ranges::all_of(of_trials, &posterior::Posterior::agreed);
  trial.log_score = gaussian_log_score(truth, found.states(), ranges);
  return trial;
}

CalibratedTrial calibrate(const sim::Parameters& truth, const ParameterDistribution& found) {
  CalibratedTrial trial = beside(truth, found);
  for (std::size_t p = 0; p < truth.size(); ++p) trial.below.push_back(found.below(static_cast<int>(p), truth[p]));
  trial.log_score = found.log_density(truth) / static_cast<double>(truth.size());
  return trial;
}

Calibration compute_calibration(std::span<const CalibratedTrial> trials, const sim::Parameters& stddev) {
  if (trials.empty()) throw Error(Code::trials_missing, "calibration", "has no trials", "give one at least");
  Calibration result;
  result.trials = static_cast<int>(trials.size());
  result.agreed = static_cast<int>(std::ranges::count_if(trials, &CalibratedTrial::agreed));
  const auto count = static_cast<double>(trials.size());
  result.band = kolmogorov_95 / std::sqrt(count);
  for (const CalibratedTrial& trial : trials) {
    result.log_score += trial.log_score / count;
    result.network_log_score += trial.network_log_score / count;
  }
  const auto is_inferred = [&](std::size_t p) {
    return std::ranges::any_of(trials,
                               [&](const CalibratedTrial& trial) { return trial.stddev[p] > fixed_sd * stddev[p]; });
  };
  double inferred = 0.0;
  for (std::size_t p = 0; p < stddev.size(); ++p) inferred += is_inferred(p) ? 1.0 : 0.0;
  // Kolmogorov's distance over 1 / sqrt(count) exceeds x with a probability of at most 2 exp(-2 x^2).
  result.band_of_all = std::sqrt(0.5 * decid::log(2.0 * std::max(inferred, 1.0) / chance) / count);
  for (std::size_t p = 0; p < stddev.size(); ++p) {
    ParameterCalibration& of = result.parameters.emplace_back();
    std::vector<double> below;
    for (const CalibratedTrial& trial : trials) {
      const double error = (trial.mean[p] - trial.truth[p]) / stddev[p], spread = trial.stddev[p] / stddev[p];
      of.mse += error * error / count;
      of.predicted_variance += spread * spread / count;
      const double miss = !trial.network ? std::numeric_limits<double>::quiet_NaN()
                                         : ((*trial.network)[p] - trial.truth[p]) / stddev[p];
      of.network_mse += miss * miss / count;
      const double off_centre = std::abs(trial.below[p] - 0.5);
      of.coverage50 += off_centre <= 0.25 ? 1.0 / count : 0.0;
      of.coverage90 += off_centre <= 0.45 ? 1.0 / count : 0.0;
      below.push_back(trial.below[p]);
    }
    of.distance = distance_from_uniform(std::move(below));
    if (!is_inferred(p)) continue;
    result.all.mse += of.mse / inferred;
    result.all.predicted_variance += of.predicted_variance / inferred;
    result.all.network_mse += of.network_mse / inferred;
    result.all.coverage50 += of.coverage50 / inferred;
    result.all.coverage90 += of.coverage90 / inferred;
    result.all.distance = std::max(result.all.distance, of.distance);
  }
  return result;
}

std::optional<NetworkCalibration> network_calibration(const Model& model, std::span<const float> outputs,
                                                      std::span<const sim::Parameters> truth) {
  if (!model.gives_distribution()) return std::nullopt;
  const std::size_t parameters = model.parameters().size(), width = model.head->outputs(parameters);
  std::vector<CalibratedTrial> trials(truth.size());
  std::vector<double> scores(truth.size() * parameters);
  parallel_for(static_cast<int>(truth.size()), [&](int index) {
    const auto i = static_cast<std::size_t>(index);
    const ParameterDistribution found = *model.distribution(outputs.subspan(i * width, width));
    trials[i] = calibrate(truth[i], found);
    const auto own = std::span(scores).subspan(i * parameters, parameters);
    for (std::size_t p = 0; p < parameters; ++p) own[p] = found.log_density(static_cast<int>(p), truth[i][p]);
  });
  NetworkCalibration result{compute_calibration(trials, model.targets.stddev), std::vector<double>(parameters)};
  const auto count = static_cast<double>(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i)
    for (std::size_t p = 0; p < parameters; ++p)
      result.log_score_per_parameter[p] += scores[i * parameters + p] / count;
  return result;
}

Calibration calibration_of_agreeing(std::span<const CalibratedTrial> trials, const sim::Parameters& stddev) {
  std::vector<CalibratedTrial> agreeing;
  std::ranges::copy_if(trials, std::back_inserter(agreeing), &CalibratedTrial::agreed);
  return compute_calibration(agreeing, stddev);
}

std::vector<CalibrationPart> calibration_by(std::span<const CalibratedTrial> trials, const sim::Parameters& stddev,
                                            const std::function<double(const sim::Parameters& truth)>& key) {
  constexpr std::size_t parts = 3;
  if (trials.size() < parts)
    throw Error(Code::trials_missing, "calibration", format("has %zu trials", trials.size()),
                "give three at least for three parts");
  std::vector<const CalibratedTrial*> sorted;
  for (const CalibratedTrial& trial : trials) sorted.push_back(&trial);
  std::ranges::stable_sort(sorted, {}, [&](const CalibratedTrial* trial) { return key(trial->truth); });
  std::vector<CalibrationPart> result;
  for (std::size_t part = 0; part < parts; ++part) {
    std::vector<CalibratedTrial> members;
    for (std::size_t i = part * sorted.size() / parts; i < (part + 1) * sorted.size() / parts; ++i)
      members.push_back(*sorted[i]);
    result.push_back({key(members.front().truth), key(members.back().truth), compute_calibration(members, stddev)});
  }
  return result;
}

double damping_ratio(const sim::Parameters& parameters, const sim::Experiment& experiment) {
  using enum sim::Coefficient;
  const sim::Body& body = experiment.body;
  const sim::Coefficients of = experiment.family().coefficients(parameters);
  const double responses = of[position] + of[gravity];
  const double stiffness = responses * of[kp] + of[kp_pass] - body.mgh();
  const double damping = responses * (of[kd] - of[kp] * of[delay]) + of[kd_pass];
  return damping / (2.0 * std::sqrt(body.inertia_kgm2 * stiffness));
}

}  // namespace decid
