// Sums of comparisons: see compared_controllers.hpp.
#include "identify/compared_controllers.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "base/error.hpp"
#include "base/text.hpp"
#include "identify/result.hpp"
#include "posterior/sampling/model_comparison.hpp"

namespace decid {
namespace {

using posterior::ComparedModel;
using posterior::LeaveOneOut;

constexpr double comparable_rhat = 1.2;
constexpr double leading_sd = 4.0, leading_nats = 4.0;

/// How much better a controller predicts a recording than the first one: the sum over the blocks.
struct Lead {
  double nats, standard_error;
  bool is_far() const { return nats > leading_nats && nats > leading_sd * standard_error; }
};

Lead lead_of(const std::vector<double>& other, const std::vector<double>& own) {
  const std::vector<ComparedModel> both = posterior::compare_models(std::vector{own, other});
  return {-both.front().difference, both.front().standard_error};
}

/// Returns whether `other` predicts far better by the blocks that few draws dominate in neither fit.
bool is_reliably_better(const LeaveOneOut& other, const LeaveOneOut& own) {
  std::vector<double> of_other, of_own;
  for (std::size_t i = 0; i < own.pointwise.size(); ++i) {
    if (own.shapes[i] > own.max_reliable_shape || other.shapes[i] > other.max_reliable_shape) continue;
    of_own.push_back(own.pointwise[i]);
    of_other.push_back(other.pointwise[i]);
  }
  return of_own.size() >= 2 && lead_of(of_other, of_own).is_far();
}

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

/// Returns the controllers that `names` lists, in its order.
std::vector<const sim::BodyModel*> find_controllers(const std::string& names, const std::string& where) {
  std::vector<const sim::BodyModel*> all;
  std::istringstream stream(names);
  for (std::string name; std::getline(stream, name, ',');) {
    const sim::BodyModel& model = sim::find_body_model(name, where);
    if (std::ranges::find(all, &model) != all.end())
      throw Error(Code::setting_conflict, where, "names " + name + " twice", "name each once");
    all.push_back(&model);
  }
  if (names.ends_with(',')) (void)sim::find_body_model("", where);  // which throws
  return all;
}

}  // namespace

std::vector<const sim::BodyModel*> controllers_to_fit(const std::string& names, const sim::Protocol& protocol,
                                                      const std::string& where) {
  const sim::BodyModel* own = protocol.experiment.body_model;
  std::vector<const sim::BodyModel*> all = find_controllers(names, where);
  if (all.empty()) return {own};
  const bool may_be_another = own == &sim::single_pendulum() && !protocol.names_controller;
  if (!may_be_another && std::ranges::find(all, own) == all.end())
    throw Error(Code::setting_conflict, where,
                "does not name " + own->name + ", the controller of protocol '" + protocol.name + "'",
                "name it too, or give a protocol without a controller");
  return all;
}

bool is_of_another(const std::string& parameter, const sim::BodyModel& controller,
                   std::span<const sim::BodyModel* const> all) {
  const auto has = [&](const sim::BodyModel* model) {
    return std::ranges::find(model->parameters, parameter, &sim::ParameterInfo::name) != model->parameters.end();
  };
  return !has(&controller) && std::ranges::any_of(all, has);
}

bool chains_allow_comparison(double max_rhat, const Warnings& warnings) {
  return max_rhat <= comparable_rhat && !has_code(warnings, "divergences");
}

std::optional<Warning> better_controller_warning(std::span<const LeaveOneOut> left_out,
                                                 const std::vector<bool>& comparable,
                                                 const std::vector<std::string>& names) {
  if (left_out.empty() || !comparable.at(0)) return std::nullopt;
  const LeaveOneOut& own = left_out.front();
  std::size_t best = 0;  // none
  Lead largest{0.0, 0.0};
  for (std::size_t k = 1; k < left_out.size(); ++k) {
    if (!comparable.at(k)) continue;
    const Lead lead = lead_of(left_out[k].pointwise, own.pointwise);
    if (!lead.is_far() || !is_reliably_better(left_out[k], own) || lead.nats <= largest.nats) continue;
    best = k;
    largest = lead;
  }
  if (best == 0) return std::nullopt;
  const std::string text =
      format("controller %s predicts this recording better than %s, by %.0f +- %.0f nats: use its parameters",
             names.at(best).c_str(), names.front().c_str(), largest.nats, largest.standard_error);
  return Warning{Severity::caution, "other_controller", text};
}

std::optional<Warning> compare_controllers(std::span<const LeaveOneOut> left_out, const std::string& own,
                                           const Warnings& warnings, FitFigures& figures) {
  std::vector<std::vector<double>> pointwise;
  for (const LeaveOneOut& one : left_out) pointwise.push_back(one.pointwise);
  const std::vector<ComparedModel> places = posterior::compare_models(pointwise);
  figures.compared = places.front();
  figures.comparable = chains_allow_comparison(figures.posterior.max_rhat(), warnings);
  std::vector<bool> comparable{figures.comparable};
  std::vector<std::string> names{own};
  for (std::size_t i = 0; i < figures.others.size(); ++i) {
    ControllerFit& other = figures.others[i];
    other.compared = places[i + 1];
    other.comparable = chains_allow_comparison(other.posterior.max_rhat(), other.warnings) &&
                       worst_trust(other.warnings) != Trust::not_usable;
    comparable.push_back(other.comparable);
    names.push_back(other.controller);
  }
  return better_controller_warning(left_out, comparable, names);
}

std::optional<ControllerSums> sum_controllers(const Report& report) {
  ControllerSums sums;
  std::vector<Comparison> all;
  for (const RecordingResult& result : report.recordings) {
    std::optional<Comparison> made = comparison_of(result, report);
    if (!made || (!all.empty() && made->names != all.front().names)) continue;  // a journal may have other controllers
    all.push_back(std::move(*made));
    sums.not_usable += result.trust() == Trust::not_usable ? 1U : 0U;
    sums.not_comparable +=
        result.fit->comparable && std::ranges::all_of(result.fit->others, &ControllerFit::comparable) ? 0U : 1U;
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
