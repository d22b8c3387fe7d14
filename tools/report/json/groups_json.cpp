// Groups compared as JSON: see groups_json.hpp.
#include "tools/report/json/groups_json.hpp"

#include "base/files/json_object.hpp"
#include "tools/report/json/cohort_json.hpp"
#include "tools/report/json/group_verdicts.hpp"
#include "tools/report/json/parameters_json.hpp"

namespace decid::tools {
namespace {

Json group_json(const Group& group, const sim::ParameterTable& parameters) {
  Json list = Json::array();
  for (std::size_t p = 0; p < parameters.size(); ++p)
    list.push_back({{"name", parameters[p].name},
                    {"mean", number_or_null(group.parameters[p].mean)},
                    {"sd", number_or_null(group.parameters[p].sd)}});
  return {{"name", group.name},
          {"participants", group.participants},
          {"recordings", group.recordings},
          {"parameters", std::move(list)}};
}

Json interval_json(const std::array<double, 2>& interval) {
  return {number_or_null(interval[0]), number_or_null(interval[1])};
}

Json pair_json(const GroupPair& pair, const std::vector<Group>& groups, const sim::ParameterTable& parameters) {
  Json list = Json::array();
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const GroupEffect& effect = pair.parameters[p];
    list.push_back({{"name", parameters[p].name},
                    {"difference", number_or_null(effect.difference)},
                    {"interval95", interval_json(effect.interval95)},
                    {"adjusted_interval95", interval_json(effect.adjusted_interval95)},
                    {"hedges_g", number_or_null(effect.hedges_g)}});
  }
  return {{"groups", {groups[pair.first].name, groups[pair.second].name}},
          {"paired", pair.paired},
          {"participants", pair.participants},
          {"unpaired_participants", pair.unpaired_participants},
          {"parameters", std::move(list)}};
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
      left_out.push_back({{"file", report.recordings[i].file}, {"group", table.members[i].cell()}, {"reason", reason}});
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
          {"reliability", reliability_json(report)}};
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
