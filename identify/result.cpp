// Results: see result.hpp.
#include "identify/result.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <utility>

#include "identify/cohort/of_result.hpp"
#include "recording/table/columns.hpp"

namespace decid {
namespace {

/// Sets the body that groups are compared at, from the recordings that are compared.
void set_body(const Report& report, GroupReport& made) {
  std::optional<double> first;
  for (std::size_t i = 0; i < report.recordings.size(); ++i) {
    if (made.table.members[i].group.empty() || !made.left_out[i].empty()) continue;
    const double mgh = report.protocol_for(report.recordings[i]).experiment.body.mgh();
    if (!first) first = mgh;
    made.bodies_differ = made.bodies_differ || mgh != *first;
    made.assumed_bodies += report.setting_of(report.recordings[i]).body_assumed ? 1U : 0U;
  }
  made.mgh_nm_rad = made.bodies_differ ? sim::Body{}.mgh() : first.value_or(report.protocol.experiment.body.mgh());
}

sim::ParameterTable ranges_of(const std::optional<FitRequest>& fit, const sim::Protocol& protocol) {
  const sim::ParameterTable table = protocol.ranges();
  return fit ? posterior::ranges_for(posterior::in_si_units(fit->priors, protocol), table) : table;
}

/// Returns the place of a warning in a list, greatest first: by its severity. A caution that names the cause of wrong
/// values is before, and a caution of how the file was read is behind the cautions that question the answer.
std::pair<Severity, int> rank(const Warning& warning) {
  if (warning.severity != Severity::caution) return {warning.severity, 0};
  if (warning.code == "scale_unlikely") return {warning.severity, 1};
  const bool is_of_reading =
      recording::one_of(warning.code, {"part_not_used", "starts_before_zero", "samples_lacking", "gaps_filled",
                                       "uneven_times", "slow_rate", "frames_left_out"});
  return {warning.severity, is_of_reading ? -1 : 0};
}

}  // namespace

std::string reason_to_leave_out(const RecordingResult& result) {
  if (result.error) return "error";
  if (result.trust() == Trust::not_usable) return name(Trust::not_usable);
  for (const std::optional<recording::TiltMatch>& tilt : {result.trial.tilt, result.trial.tilt_at_given_start})
    if (tilt && tilt->is_other_size) return "tilt_of_other_size";
  return {};
}

const char* name(FitFigures::Answer answer) {
  return answer == FitFigures::Answer::network ? "network" : "posterior";
}

double RecordingResult::peak_to_peak_deg() const {
  const std::vector<float>& sway_rad = trial.sway_rad();
  if (sway_rad.empty()) return 0.0;
  if (std::ranges::any_of(sway_rad, [](float value) { return std::isnan(value); })) return std::nan("");
  const auto [low, high] = std::ranges::minmax(sway_rad);
  return static_cast<double>(high - low) / sim::rad_per_deg;
}

Warnings most_severe_first(std::initializer_list<Warnings> lists) {
  Warnings all;
  for (const Warnings& list : lists) all.insert(all.end(), list.begin(), list.end());
  std::ranges::stable_sort(all, std::greater<>(), rank);
  return all;
}

sim::ParameterTable Report::ranges() const {
  return ranges_of(fit, protocol);
}

sim::ParameterTable Report::ranges_for(const RecordingResult& recording) const {
  return ranges_of(fit, protocol_for(recording));
}

posterior::Priors Report::priors_for(const RecordingResult& recording) const {
  return fit ? posterior::in_si_units(fit->priors, protocol_for(recording)) : posterior::Priors{};
}

std::vector<std::string> Report::fixed_parameters() const {
  std::vector<std::string> names;
  if (!fit) return names;
  for (const std::string& name : protocol.parameters().names())
    if (std::ranges::any_of(fit->priors.parameters,
                            [&](const posterior::ParameterPrior& prior) { return prior.name == name && prior.fixed; }))
      names.push_back(name);
  return names;
}

std::vector<std::size_t> Report::inferred_parameters() const {
  const std::vector<std::string> fixed = fixed_parameters();
  const sim::ParameterTable& table = protocol.parameters();
  std::vector<std::size_t> places;
  for (std::size_t p = 0; p < table.size(); ++p)
    if (std::ranges::find(fixed, table[p].name) == fixed.end()) places.push_back(p);
  return places;
}

sim::ParameterTable Report::compared_parameters() const {
  std::vector<sim::ParameterInfo> kept;
  for (const std::size_t p : inferred_parameters()) kept.push_back(protocol.parameters()[p]);
  if (kept.empty())
    throw Error(Code::setting_conflict, "groups", "all parameters are fixed, so there is nothing to compare",
                "fix fewer of them, or leave the groups out");
  return sim::ParameterTable(std::move(kept));
}

double scale_to(double mgh_nm_rad, const Report& report, const RecordingResult& result, std::size_t parameter) {
  return report.protocol.parameters()[parameter].scales_with_mgh
             ? mgh_nm_rad / report.protocol_for(result).experiment.body.mgh()
             : 1.0;
}

GroupReport report_groups(GroupTable table, const Report& report) {
  const std::size_t parameters = report.compared_parameters().size();
  const std::vector<std::size_t> places = report.inferred_parameters();
  GroupReport made{std::move(table), {}, {}};
  for (std::size_t i = 0; i < report.recordings.size(); ++i) {
    const GroupMember& member = made.table.members.at(i);
    const RecordingResult& result = report.recordings[i];
    if (!member.group.empty() || (result.error && !member.missing.empty()))
      made.left_out.push_back(reason_to_leave_out(result));
    else
      made.left_out.push_back(member.missing.empty() ? "" : "without_" + member.missing);
  }
  set_body(report, made);
  std::vector<GroupedRecording> participants;
  std::vector<cohort::Recording> members(report.recordings.size());
  std::map<std::string, const GroupMember*> cells;  // one of each
  cohort::FirstOfJoint is_first;
  for (std::size_t i = 0; i < report.recordings.size(); ++i) {
    const GroupMember& member = made.table.members[i];
    if (member.group.empty()) continue;
    const sim::Parameters& values = report.recordings[i].estimate.parameters;
    GroupedRecording& one = participants.emplace_back(GroupedRecording{member.cell(), member.participant, {}});
    cells.emplace(one.group, &member);
    if (!made.left_out[i].empty()) continue;
    if (is_first(report.recordings[i]))
      for (const std::size_t p : places)
        one.values.push_back(scale_to(made.mgh_nm_rad, report, report.recordings[i], p) * values[p]);
    members[i] = {member.participant, member.session, member.group, member.condition, member.covariates, {}};
  }
  const auto order_of = [&](const std::string& first, const std::string& second) {
    const GroupMember &a = *cells.at(first), &b = *cells.at(second);
    if (!cohort::differ_in_one(a, b)) return PairOrder::not_compared;
    return cohort::second_is_minuend(a, b) ? PairOrder::second_minus_first : PairOrder::first_minus_second;
  };
  made.comparison = compare_groups(participants, parameters, order_of);
  cohort::Analysis analysis = cohort::analyse_groups(report, members, made.table.covariates, made.mgh_nm_rad);
  made.hierarchical = std::move(analysis.result);
  made.without_distribution = std::move(analysis.without_evidence);
  for (const GroupPair& pair : made.comparison.pairs) {
    made.reliability.emplace_back();
    if (!pair.paired) continue;
    const std::string &first = made.comparison.groups[pair.first].name,
                      &second = made.comparison.groups[pair.second].name;
    if (pair.participants[0] > 1)
      made.reliability.back() = cohort::compute_reliability(report, members, first, second, made.mgh_nm_rad);
    std::ranges::move(cohort::compute_own_changes(report, members, first, second, made.mgh_nm_rad),
                      std::back_inserter(made.own_changes));
  }
  if (made.hierarchical) cohort::add_own_changes(made.own_changes, *made.hierarchical);
  return made;
}

}  // namespace decid
