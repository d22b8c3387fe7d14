// Recalibration: see recalibration.hpp.
#include "identify/network/recalibration.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "identify/network/model.hpp"
#include "identify/network/prediction.hpp"

namespace decid {
namespace {

constexpr int max_shown_trials = 10'240, min_shown_trials = 1'000;
constexpr double probability_step = 1.0 / (Recalibration::probabilities + 1);
/// Levels of a network that is always certain and wrong would be 0 or 1, where quantiles do not exist.
constexpr double min_level = 1e-9;

/// The map's corner `i` of 0 .. probabilities + 1.
double corner(const Recalibration::Levels& levels, std::size_t i) {
  if (i == 0) return 0.0;
  return i <= levels.size() ? levels[i - 1] : 1.0;
}

/// Position among n sorted values below which a new value lies with this probability: k of them are below with
/// probability k / (n + 1) each.
double make_quantile(const std::vector<double>& sorted, double probability) {
  const double place = probability * static_cast<double>(sorted.size() + 1) - 1.0;
  const double inside = std::clamp(place, 0.0, static_cast<double>(sorted.size() - 1));
  const auto below = static_cast<std::size_t>(inside), above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (inside - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace

double Recalibration::level(std::size_t parameter, double probability) const {
  if (!known()) return probability;
  const Levels& all = levels[parameter];
  const auto part = std::min(static_cast<std::size_t>(probability / probability_step), probabilities);
  const double low = corner(all, part), high = corner(all, part + 1);
  return low + (high - low) * (probability / probability_step - static_cast<double>(part));
}

double Recalibration::probability(std::size_t parameter, double level) const {
  if (!known()) return level;
  const Levels& all = levels[parameter];
  const auto above = std::ranges::upper_bound(all, level);
  const auto part = static_cast<std::size_t>(above - all.begin());
  const double low = corner(all, part), high = corner(all, part + 1);
  return probability_step * (static_cast<double>(part) + (level - low) / (high - low));
}

// The factor weighs trials by their predicted variance. A few trials near an end of the range, with almost no standard
// deviation, would dominate the mean of (error / deviation)^2.
Recalibration fit_recalibration(std::size_t parameters, std::span<const PredictedParameter> predicted) {
  if (parameters == 0 || predicted.empty() || predicted.size() % parameters != 0)
    throw Error(Code::size_mismatch, "recalibration",
                format("%zu values for trials of %zu parameters", predicted.size(), parameters),
                "give one for each trial and parameter");
  Recalibration made;
  for (std::size_t p = 0; p < parameters; ++p) {
    std::vector<double> sorted;
    double errors = 0.0, variances = 0.0;
    for (std::size_t i = p; i < predicted.size(); i += parameters) {
      sorted.push_back(predicted[i].below);
      errors += predicted[i].error * predicted[i].error;
      variances += predicted[i].stddev * predicted[i].stddev;
    }
    std::ranges::sort(sorted);
    Recalibration::Levels& levels = made.levels.emplace_back();
    for (std::size_t i = 0; i < levels.size(); ++i)
      levels[i] =
          std::clamp(make_quantile(sorted, probability_step * static_cast<double>(i + 1)), min_level, 1.0 - min_level);
    const double factor = std::sqrt(errors / variances);
    if (!(factor > 0.0 && std::isfinite(factor)))
      throw Error(Code::value_invalid, "recalibration",
                  format("the errors or the standard deviations of parameter %zu are all 0, or not finite", p + 1),
                  "train the network for longer, or with a lower learning rate");
    made.stddev_factor.push_back(factor);
  }
  return made;
}

Recalibration learn_recalibration(const Model& model, const dataset::TrialSource& source, int next_epoch,
                                  Communicator* ranks) {
  const int trials = std::min(source.trials(dataset::Part::unseen), max_shown_trials);
  if (!model.gives_distribution() || trials < min_shown_trials) return {};
  const sim::ParameterTable& table = model.parameters();
  const OutputsOf shown = compute_outputs(model, source, dataset::Part::unseen, next_epoch, trials, ranks);
  const std::size_t width = model.head->outputs(table.size());
  std::vector<PredictedParameter> predicted(shown.truth.size() * table.size());
  parallel_for(trials, [&](int index) {
    const auto i = static_cast<std::size_t>(index);
    const auto own = std::span<const float>(shown.outputs).subspan(i * width, width);
    const ParameterDistribution found(*model.head->distribution(own, table.size()), table);
    for (std::size_t p = 0; p < table.size(); ++p) {
      const int quantity = static_cast<int>(p);
      const double truth = shown.truth[i][p];
      predicted[i * table.size() + p] = {found.below(quantity, truth), truth - found.mean(quantity),
                                         found.stddev(quantity)};
    }
  });
  return fit_recalibration(table.size(), predicted);
}

std::string to_json(const Recalibration& recalibration) {
  return Json{{"levels", recalibration.levels}, {"deviation_factor", recalibration.stddev_factor}}.dump();
}

Recalibration recalibration_from_json(const std::string& text, std::size_t parameters, const std::string& where) {
  const std::string remedy = "give a model file written by decid train";
  Recalibration read;
  try {
    const Json json = parse_json(text, where);
    for (const Json& list : json.at("levels")) {
      if (list.size() != Recalibration::probabilities)
        throw Error(Code::file_damaged, where, format("has a recalibration of %zu levels", list.size()), remedy);
      Recalibration::Levels& levels = read.levels.emplace_back();
      for (std::size_t i = 0; i < levels.size(); ++i) levels[i] = list.at(i).get<double>();
    }
    read.stddev_factor = json.at("deviation_factor").get<std::vector<double>>();
  } catch (const Json::exception&) {
    throw Error(Code::file_damaged, where, "has a recalibration that cannot be read", remedy);
  }
  if (read.levels.size() != parameters || read.stddev_factor.size() != parameters)
    throw Error(Code::file_damaged, where, "has a recalibration of another number of parameters", remedy);
  for (const Recalibration::Levels& levels : read.levels)
    if (!(levels.front() > 0.0) || !(levels.back() < 1.0) || !std::ranges::is_sorted(levels))
      throw Error(Code::file_damaged, where, "has a recalibration whose levels do not rise from 0 to 1", remedy);
  for (const double factor : read.stddev_factor)
    if (!(factor > 0.0) || !std::isfinite(factor))
      throw Error(Code::file_damaged, where, "has a recalibration whose deviations are not above 0", remedy);
  return read;
}

}  // namespace decid
