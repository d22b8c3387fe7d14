// Fits of realistic recordings: see fit_conditions.hpp.
#include "identify/evaluation/fit_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.hpp"
#include "identify/evaluation/calibration_trials.hpp"

namespace decid {
namespace {

constexpr double far_off_sd = 5.0;

/// Returns the largest error of an inferred parameter, in standard deviations.
double furthest(const CalibratedTrial& answer) {
  double largest = 0.0;
  for (std::size_t p = 0; p < answer.truth.size(); ++p)
    if (answer.stddev[p] > 0.0)
      largest = std::max(largest, std::abs(answer.mean[p] - answer.truth[p]) / answer.stddev[p]);
  return largest;
}

std::vector<RecordingResult> recordings_of(FaultTrials::Trials& made) {
  std::vector<RecordingResult> recordings(made.sways.size());
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    recordings[i].file = "trial " + std::to_string(i);
    recordings[i].trial = std::move(made.sways[i]);
    recordings[i].warnings = std::move(made.warnings[i]);
  }
  return recordings;
}

void count_trust(const RecordingResult& id, bool far_off, FitConditionFigures& row) {
  const Trust trust = id.trust();
  row.usable += trust == Trust::usable ? 1 : 0;
  row.caution += trust == Trust::caution ? 1 : 0;
  row.not_usable += trust == Trust::not_usable ? 1 : 0;
  row.usable_far_off += trust == Trust::usable && far_off ? 1 : 0;
  std::set<std::string> codes;
  for (const Warning& warning : id.warnings)
    if (warning.severity != Severity::info) codes.insert(warning.code);
  for (const std::string& code : codes) ++row.codes[code];
}

}  // namespace

std::vector<FitCondition> fit_conditions(const sim::Protocol& protocol) {
  sim::Protocol all = protocol;
  all.heights = {};  // a fit knows the body
  sim::Protocol none = all;
  none.conditions = {};
  std::vector<FitCondition> rows{{{"none", 0.0, "as simulated"}, none}};
  for (std::size_t c = 0; c < sim::condition_count; ++c) {
    const auto condition = static_cast<sim::Condition>(c);
    if (protocol.conditions[condition].fraction == 0.0) continue;
    sim::Protocol alone = none;
    alone.conditions[condition] = protocol.conditions[condition];
    alone.conditions[condition].fraction = 1.0;
    rows.push_back({{sim::info(condition).key, 0.0, "with this condition"}, alone});
  }
  if (rows.size() > 2) rows.push_back({{"all", 0.0, "with all conditions"}, all});
  return rows;
}

std::vector<FitCondition> fit_faults(const sim::Protocol& protocol, const posterior::Priors& priors) {
  sim::Protocol recorded = protocol;
  recorded.conditions = {};
  recorded = with_priors(std::move(recorded), priors);
  std::vector<FitCondition> rows;
  for (const Fault& fault : faults_of_people())
    if (impossible(protocol, fault).empty()) rows.push_back({fault, with_fault(recorded, fault)});
  return rows;
}

FitConditionFigures fit_condition(const Model& model, const sim::Protocol& protocol, const FitCondition& condition,
                                  const FitRequest& request, int trials, std::uint64_t seed,
                                  const FitProgress& progress) {
  FitConditionFigures row;
  row.fault = condition.fault;
  FaultTrials::Trials made = FaultTrials(protocol, condition.recorded, condition.fault, seed).take(0, trials);
  if (made.sways.empty())
    throw Error(Code::body_falls, "protocol " + protocol.name, "no trial stands " + condition.fault.text,
                "use a smaller stimulus");
  std::vector<RecordingResult> fitted = recordings_of(made);
  if (!Fitter(&model, protocol, {}, request).fit(fitted, progress)) return row;
  const sim::ParameterTable ranges = protocol.ranges();
  row.trials = static_cast<int>(fitted.size());
  std::vector<CalibratedTrial> answers, usable;
  for (std::size_t i = 0; i < fitted.size(); ++i) {
    const RecordingResult& id = fitted[i];
    if (id.error) throw Error(*id.error);
    const FitFigures& fit = *id.fit;
    const bool from_network = fit.answer == FitFigures::Answer::network && id.estimate.distribution;
    if (!made.truth.empty()) {
      answers.push_back(from_network ? calibrate(made.truth[i], *id.estimate.distribution)
                                     : calibrate(made.truth[i], std::span(&fit.posterior, 1), ranges));
      answers.back().network = fit.network;
      if (id.trust() == Trust::usable) usable.push_back(answers.back());
    }
    row.from_network += from_network ? 1 : 0;
    count_trust(id, !answers.empty() && furthest(answers.back()) > far_off_sd, row);
    row.mean_s += fit.seconds / static_cast<double>(fitted.size());
    row.max_s = std::max(row.max_s, fit.seconds);
  }
  if (answers.empty()) return row;
  row.figures = compute_calibration(answers, uniform_stddev(ranges));
  if (!usable.empty()) row.usable_figures = compute_calibration(usable, uniform_stddev(ranges));
  return row;
}

}  // namespace decid
