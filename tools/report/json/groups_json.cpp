// Groups compared as JSON: see groups_json.hpp.
#include "tools/report/json/groups_json.hpp"

#include "base/files/json_object.hpp"
#include "tools/report/json/group_verdicts.hpp"
#include "tools/report/json/parameters_json.hpp"

namespace decid::tools {
namespace {

/// Returns a list of what `describe` adds to each parameter's name.
template <class Describe>
Json each_parameter(const sim::ParameterTable& parameters, const Describe& describe) {
  Json list = Json::array();
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    Json& one = list.emplace_back(Json{{"name", parameters[p].name}});
    describe(p, one);
  }
  return list;
}

Json effects_json(const std::vector<cohort::Effect>& effects, const sim::ParameterTable& parameters) {
  return each_parameter(parameters, [&](std::size_t p, Json& one) {
    const cohort::Effect& effect = effects[p];
    one["difference"] = effect.difference.mean;
    one["sd"] = effect.difference.sd;
    one["interval95"] = effect.difference.interval95;
    one["simultaneous95"] = effect.simultaneous95;
    one["standardised"] = effect.standardised.mean;
    one["standardised_interval95"] = effect.standardised.interval95;
    one["probability_of_direction"] = effect.direction;
  });
}

/// The names of a comparison's cells.
Json pair_of(const cohort::Result& found, const cohort::Comparison& comparison) {
  return {found.cells[comparison.first].name(), found.cells[comparison.second].name()};
}

Json covariate_json(const cohort::Covariate& covariate, const sim::ParameterTable& parameters) {
  return {{"name", covariate.name},
          {"mean", covariate.mean},
          {"unknown", covariate.unknown},
          {"parameters", each_parameter(parameters, [&](std::size_t p, Json& one) {
             const cohort::Slope& slope = covariate.slopes[p];
             one["slope"] = slope.mean;
             one["sd"] = slope.sd;
             one["interval95"] = slope.interval95;
             one["probability_of_direction"] = slope.direction;
           })}};
}

/// Returns
///   {"draws", "max_rhat",
///    "groups": [{"name", "group", "session", "condition", "participants", "recordings", "parameters": [{"name",
///    "mean",
///                "mean_sd", "mean_interval95", "between_sd", "between_sd_interval95"}]}],
///    "comparisons": [{"groups": [a, b], "participants_in_both", "parameters": [{"name", "difference", "sd",
///    "interval95",
///                     "simultaneous95", "standardised", "standardised_interval95", "probability_of_direction"}]}],
///    "interactions": [{"first": [a, b], "second": [c, d], "parameters": as of comparisons}],
///    "covariates": [{"name", "mean", "unknown", "parameters": [{"name", "slope", "sd", "interval95",
///                    "probability_of_direction"}]}],
///    "variance": [{"name", "participant_sd", "visit_sd", "trial_sd", "measurement_sd"}],
///    "changes": [{"participant_id", "groups": [a, b], "parameters": [{"name", "difference", "interval95",
///    "own_difference", "own_interval95", "changed"}]}]}
/// and null without a hierarchical model.
Json cohort_json(const Report& report) {
  if (!report.groups || !report.groups->hierarchical) return nullptr;
  const cohort::Result& found = *report.groups->hierarchical;
  const sim::ParameterTable parameters = report.compared_parameters();
  Json groups = Json::array(), comparisons = Json::array(), interactions = Json::array(), changes = Json::array(),
       covariates = Json::array();
  for (const cohort::Cell& cell : found.cells)
    groups.push_back({{"name", cell.name()},
                      {"group", cell.group},
                      {"session", text_or_null(cell.session)},
                      {"condition", text_or_null(cell.condition)},
                      {"participants", cell.participants},
                      {"recordings", cell.recordings},
                      {"parameters", each_parameter(parameters, [&](std::size_t p, Json& one) {
                         one["mean"] = cell.mean[p].mean;
                         one["mean_sd"] = cell.mean[p].sd;
                         one["mean_interval95"] = cell.mean[p].interval95;
                         one["between_sd"] = cell.between_sd[p].mean;
                         one["between_sd_interval95"] = cell.between_sd[p].interval95;
                       })}});
  for (const cohort::Comparison& comparison : found.comparisons)
    comparisons.push_back({{"groups", pair_of(found, comparison)},
                           {"participants_in_both", comparison.participants_in_both},
                           {"parameters", effects_json(comparison.effects, parameters)}});
  for (const cohort::Interaction& one : found.interactions)
    interactions.push_back({{"first", pair_of(found, found.comparisons[one.first])},
                            {"second", pair_of(found, found.comparisons[one.second])},
                            {"parameters", effects_json(one.effects, parameters)}});
  for (const cohort::Covariate& covariate : found.covariates)
    covariates.push_back(covariate_json(covariate, parameters));
  for (const cohort::Change& change : found.changes) {
    const cohort::Comparison& comparison = found.comparisons[change.comparison];
    changes.push_back({{"participant_id", found.visits[change.first].participant},
                       {"groups", pair_of(found, comparison)},
                       {"parameters", each_parameter(parameters, [&](std::size_t p, Json& one) {
                          one["difference"] = change.difference[p].mean;
                          one["interval95"] = change.difference[p].interval95;
                          if (!change.own.empty()) {
                            one["own_difference"] = change.own[p].mean;
                            one["own_interval95"] = change.own[p].interval95;
                          }
                          one["changed"] = change.changed(p);
                        })}});
  }
  return {{"draws", found.draws},
          {"max_rhat", found.max_rhat},
          {"groups", std::move(groups)},
          {"comparisons", std::move(comparisons)},
          {"interactions", std::move(interactions)},
          {"covariates", std::move(covariates)},
          {"variance", each_parameter(parameters,
                                      [&](std::size_t p, Json& one) {
                                        one["participant_sd"] = found.variances[p].participant.mean;
                                        one["visit_sd"] = found.variances[p].visit.mean;
                                        one["trial_sd"] = found.variances[p].trial.mean;
                                        one["measurement_sd"] = found.variances[p].measurement;
                                      })},
          {"changes", std::move(changes)}};
}

/// Returns a list as "changes" of the hierarchical model, by each person's own recordings.
Json own_changes_json(const Report& report) {
  Json changes = Json::array();
  const sim::ParameterTable parameters = report.compared_parameters();
  for (const cohort::OwnChange& change : report.groups->own_changes)
    changes.push_back({{"participant_id", change.participant},
                       {"groups", {change.first, change.second}},
                       {"caution", change.has_caution},
                       {"parameters", each_parameter(parameters, [&](std::size_t p, Json& one) {
                          one["difference"] = change.difference[p].mean;
                          one["sd"] = change.difference[p].sd;
                          one["interval95"] = change.difference[p].interval95;
                          one["changed"] = cohort::excludes_zero(change.difference[p]);
                        })}});
  return changes;
}

Json interval_json(const std::array<double, 2>& interval) {
  return {number_or_null(interval[0]), number_or_null(interval[1])};
}

/// Returns the reliability of each pair of groups with participants in both:
///   [{"groups": [a, b], "participants", "parameters": [{"name", "icc_single", "icc_single_interval95", "icc_average",
///     "icc_average_interval95", "standard_error", "minimal_detectable_change", "participant_sd", "visit_sd",
///     "measurement_sd", "within_participant_sd", "shown_fraction"}]}]
/// An ICC or an end of its interval is null where cohort::Reliability has none.
Json reliability_json(const Report& report) {
  Json list = Json::array();
  if (!report.groups) return list;
  const GroupComparison& compared = report.groups->comparison;
  const sim::ParameterTable parameters = report.compared_parameters();
  for (std::size_t i = 0; i < report.groups->reliability.size(); ++i) {
    const auto& of_pair = report.groups->reliability[i];
    const GroupPair& pair = compared.pairs[i];
    if (of_pair.empty()) continue;
    list.push_back({{"groups", {compared.groups[pair.first].name, compared.groups[pair.second].name}},
                    {"participants", pair.participants[0]},
                    {"parameters", each_parameter(parameters, [&](std::size_t p, Json& one) {
                       if (!of_pair[p]) return;
                       const cohort::Reliability& found = *of_pair[p];
                       one["icc_single"] = number_or_null(found.icc_single);
                       one["icc_single_interval95"] = interval_json(found.icc_single95);
                       one["icc_average"] = number_or_null(found.icc_average);
                       one["icc_average_interval95"] = interval_json(found.icc_average95);
                       one["standard_error"] = found.standard_error;
                       one["minimal_detectable_change"] = found.minimal_detectable_change;
                       one["participant_sd"] = found.participant_sd;
                       one["visit_sd"] = found.visit_sd;
                       one["measurement_sd"] = found.measurement_sd;
                       one["within_participant_sd"] = found.within_participant_sd;
                       one["shown_fraction"] = found.shown_fraction;
                     })}});
  }
  return list;
}

Json group_json(const Group& group, const sim::ParameterTable& parameters) {
  return {{"name", group.name},
          {"participants", group.participants},
          {"recordings", group.recordings},
          {"parameters", each_parameter(parameters, [&](std::size_t p, Json& one) {
             one["mean"] = number_or_null(group.parameters[p].mean);
             one["sd"] = number_or_null(group.parameters[p].sd);
           })}};
}

Json pair_json(const GroupPair& pair, const std::vector<Group>& groups, const sim::ParameterTable& parameters) {
  return {{"groups", {groups[pair.first].name, groups[pair.second].name}},
          {"paired", pair.paired},
          {"participants", pair.participants},
          {"unpaired_participants", pair.unpaired_participants},
          {"parameters", each_parameter(parameters, [&](std::size_t p, Json& one) {
             const GroupEffect& effect = pair.parameters[p];
             one["difference"] = number_or_null(effect.difference);
             one["interval95"] = interval_json(effect.interval95);
             one["adjusted_interval95"] = interval_json(effect.adjusted_interval95);
             one["hedges_g"] = number_or_null(effect.hedges_g);
           })}};
}

}  // namespace

Json groups_json(const Report& report) {
  if (!report.groups) return nullptr;
  const GroupComparison& found = report.groups->comparison;
  const GroupTable& table = report.groups->table;
  const sim::ParameterTable parameters = report.compared_parameters();
  Json groups = Json::array(), comparisons = Json::array(), left_out = Json::array(), unused = Json::array();
  for (const Group& group : found.groups) groups.push_back(group_json(group, parameters));
  for (const GroupPair& pair : found.pairs) comparisons.push_back(pair_json(pair, found.groups, parameters));
  for (std::size_t i = 0; i < report.recordings.size(); ++i)
    if (const std::string& reason = report.groups->left_out[i]; !reason.empty())
      left_out.push_back(
          {{"file", report.recordings[i].file}, {"group", text_or_null(table.members[i].cell())}, {"reason", reason}});
  Json without = Json::array(), reasons = Json::array(), too_small = Json::array();
  for (const cohort::WithoutEvidence& one : report.groups->without_distribution) {
    without.push_back(report.recordings[one.recording].file);
    reasons.push_back(one.reason);
  }
  for (const std::size_t place : found.too_small) too_small.push_back(found.groups[place].name);
  for (const UnusedLine& line : table.unused) unused.push_back({{"line", line.line}, {"file", line.file}});
  return {{"groups", std::move(groups)},
          {"comparisons", std::move(comparisons)},
          {"group_comparison",
           {{"participant_column", table.participant_column.empty() ? Json(nullptr) : Json(table.participant_column)},
            {"parameters", parameters.size()},
            {"fixed_parameters", report.fixed_parameters()},
            {"pairs", found.pairs.size()},
            {"intervals", found.intervals},
            {"too_small_groups", std::move(too_small)},
            {"adjustment", "bonferroni"},
            {"covariates", table.covariates},
            {"mgh", report.groups->mgh_nm_rad},
            {"bodies_differ", report.groups->bodies_differ},
            {"assumed_bodies", report.groups->assumed_bodies},
            {"left_out", std::move(left_out)},
            {"without_distribution", std::move(without)},
            {"without_distribution_reasons", std::move(reasons)},
            {"unused_lines", std::move(unused)},
            {"notes", group_verdicts(report).notes}}},
          {"hierarchical", cohort_json(report)},
          {"reliability", reliability_json(report)},
          {"own_changes", own_changes_json(report)}};
}

Json page_groups(const Report& report) {
  Json page = groups_json(report);
  if (page.is_null()) return page;
  const GroupVerdicts verdicts = group_verdicts(report);
  page["verdicts"] = {{"intervals", verdicts.intervals}, {"sentences", verdicts.sentences}, {"notes", verdicts.notes}};
  page["members"] = Json::array();
  for (std::size_t i = 0; i < report.recordings.size(); ++i)
    if (!report.recordings[i].error)
      page["members"].push_back(
          {{"group", report.groups->table.members[i].cell()}, {"left_out", report.groups->left_out[i]}});
  return page;
}

}  // namespace decid::tools
