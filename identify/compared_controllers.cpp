// Sums of comparisons: see compared_controllers.hpp.
#include "identify/compared_controllers.hpp"

#include <algorithm>
#include <cmath>

#include "identify/result.hpp"

namespace decid {
namespace {

using posterior::ComparedModel;

/// The controllers of one recording, the one that answers first.
struct Comparison {
  std::vector<std::string> names;
  std::vector<ComparedModel> models;

  /// Returns the place of the largest density, the first of several.
  std::size_t best() const {
    return static_cast<std::size_t>(std::ranges::max_element(models, {}, &ComparedModel::log_density) - models.begin());
  }
};

std::optional<Comparison> comparison_of(const RecordingResult& result, const Report& report) {
  if (result.error || !result.fit || !result.fit->compared) return std::nullopt;
  Comparison made{{report.protocol_for(result).experiment.body_model->name}, {*result.fit->compared}};
  for (const ControllerFit& other : result.fit->others) {
    made.names.push_back(other.controller);
    made.models.push_back(other.compared);
  }
  return made;
}

/// Returns the standard error of the difference of two controllers, or a bound: see sum_controllers().
double standard_error(const Comparison& comparison, std::size_t one, std::size_t other) {
  const std::size_t best = comparison.best();  // whose standard error is 0
  const auto to_best = [&](std::size_t k) { return k == best ? 0.0 : comparison.models[k].standard_error; };
  return one == other ? 0.0 : to_best(one) + to_best(other);
}

}  // namespace

std::optional<ControllerSums> sum_controllers(const Report& report) {
  ControllerSums sums;
  std::vector<Comparison> all;
  for (const RecordingResult& result : report.recordings) {
    std::optional<Comparison> made = comparison_of(result, report);
    if (!made || (!all.empty() && made->names != all.front().names)) continue;  // a journal may have other controllers
    all.push_back(std::move(*made));
    sums.not_usable += result.trust() == Trust::not_usable ? 1U : 0U;
  }
  if (all.size() < 2) return std::nullopt;
  sums.recordings = all.size();
  for (const std::string& name : all.front().names) sums.controllers.push_back({.name = name});
  for (const Comparison& comparison : all) {
    ++sums.controllers[comparison.best()].best_in;
    for (std::size_t k = 0; k < sums.controllers.size(); ++k)
      sums.controllers[k].log_density += comparison.models[k].log_density;
  }
  const auto best = static_cast<std::size_t>(
      std::ranges::max_element(sums.controllers, {}, &SummedController::log_density) - sums.controllers.begin());
  for (std::size_t k = 0; k < sums.controllers.size(); ++k) {
    double squares = 0.0;
    for (const Comparison& comparison : all) {
      const double error = standard_error(comparison, k, best);
      squares = std::fma(error, error, squares);
      sums.controllers[k].difference += comparison.models[k].log_density - comparison.models[best].log_density;
    }
    sums.controllers[k].standard_error = std::sqrt(squares);
  }
  return sums;
}

}  // namespace decid
