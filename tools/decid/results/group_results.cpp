// Groups compared as JSON and text: see group_results.hpp.
#include "tools/decid/results/group_results.hpp"

#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "identify/groups.hpp"
#include "tools/report/parameters_json.hpp"

namespace decid::tools {
namespace {

/// Empty if the recording counts.
std::string reason_to_leave_out(const Json& recording) {
  if (recording.contains("error")) return "error";
  if (recording.at("trust") == "not usable") return "not usable";
  for (const Json& warning : recording.at("warnings"))
    if (warning.at("code") == "tilt_of_other_size") return "tilt_of_other_size";
  return {};
}

std::vector<double> values_of(const Json& recording) {
  std::vector<double> values;
  for (const Json& parameter : recording.at("parameters")) values.push_back(parameter.at("value"));
  return values;
}

Json group_json(const Group& group, const sim::ParameterTable& parameters) {
  Json list = Json::array();
  for (std::size_t p = 0; p < parameters.size(); ++p)
    list.push_back({{"name", parameters[p].name},
                    {"mean", number_or_null(group.parameters[p].mean)},
                    {"sd", number_or_null(group.parameters[p].sd)}});
  return {{"name", group.name},
          {"people", group.people},
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
          {"people", pair.people},
          {"unpaired_people", pair.unpaired_people},
          {"parameters", std::move(list)}};
}

std::string number_text(const Json& value, const char* pattern) {
  if (!value.is_number()) return "-";
  char text[64];
  std::snprintf(text, sizeof text, pattern, value.get<double>());
  return text;
}

std::string interval_text(const Json& interval) {
  return number_text(interval.at(0), "%.4g") + " to " + number_text(interval.at(1), "%.4g");
}

std::string people_text(const Json& count) {
  return count == 1 ? "1 person" : format("%d people", count.get<int>());
}

std::string group_text(const Json& group) {
  std::string text = "  " + one_line(group.at("name")) + ": " + people_text(group.at("people")) + ", " +
                     counted(group.at("recordings"), "recording") + "\n";
  for (const Json& parameter : group.at("parameters"))
    text += format("    %-8s %12s +- %s\n", parameter.at("name").get<std::string>().c_str(),
                   number_text(parameter.at("mean"), "%.5g").c_str(), number_text(parameter.at("sd"), "%.3g").c_str());
  return text;
}

std::string pair_text(const Json& pair) {
  std::string text = "  " + one_line(pair.at("groups").at(0)) + " less " + one_line(pair.at("groups").at(1));
  text += pair.at("paired")
              ? ", paired: " + people_text(pair.at("people").at(0)) + " in both groups\n"
              : ": " + people_text(pair.at("people").at(0)) + " and " + people_text(pair.at("people").at(1)) + "\n";
  if (pair.at("unpaired_people") != 0)
    text += "    without " + people_text(pair.at("unpaired_people")) + " in only one of the two groups\n";
  text += format("    %-8s %12s %24s %24s %10s\n", "", "difference", "95% interval", "adjusted interval", "Hedges' g");
  for (const Json& parameter : pair.at("parameters"))
    text += format("    %-8s %12s %24s %24s %10s\n", parameter.at("name").get<std::string>().c_str(),
                   number_text(parameter.at("difference"), "%.4g").c_str(),
                   interval_text(parameter.at("interval95")).c_str(),
                   interval_text(parameter.at("adjusted_interval95")).c_str(),
                   number_text(parameter.at("hedges_g"), "%.2f").c_str());
  return text;
}

std::string left_out_text(const Json& left_out) {
  if (left_out.empty()) return {};
  std::string text = "  Left out: " + counted(static_cast<long long>(left_out.size()), "recording") + "\n";
  for (const Json& recording : left_out)
    text += "    " + one_line(recording.at("file")) + " (" + one_line(recording.at("group")) +
            "): " + recording.at("reason").get<std::string>() + "\n";
  return text;
}

}  // namespace

Json groups_json(Json& recordings, const GroupTable& table, const sim::ParameterTable& parameters) {
  std::vector<GroupedRecording> compared;
  Json left_out = Json::array();
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const GroupMember& member = table.members.at(i);
    if (member.group.empty()) continue;
    Json& recording = recordings[i];
    recording["group"] = member.group;
    if (!table.person_column.empty()) recording["subject"] = member.person;
    const std::string reason = reason_to_leave_out(recording);
    if (!reason.empty())
      left_out.push_back({{"file", recording.at("file")}, {"group", member.group}, {"reason", reason}});
    compared.push_back({member.group, member.person, reason.empty() ? values_of(recording) : std::vector<double>()});
  }
  Json unused = Json::array();
  for (const UnusedLine& line : table.unused) unused.push_back({{"line", line.line}, {"file", line.file}});
  const GroupComparison found = compare_groups(compared, parameters.size());
  Json json{{"groups", Json::array()}, {"comparisons", Json::array()}};
  for (const Group& group : found.groups) json["groups"].push_back(group_json(group, parameters));
  for (const GroupPair& pair : found.pairs) json["comparisons"].push_back(pair_json(pair, found.groups, parameters));
  json["group_comparison"] = {
      {"person_column", table.person_column.empty() ? Json(nullptr) : Json(table.person_column)},
      {"parameters", parameters.size()},
      {"pairs", found.pairs.size()},
      {"intervals", found.intervals},
      {"adjustment", "bonferroni"},
      {"left_out", std::move(left_out)},
      {"unused_lines", std::move(unused)}};
  return json;
}

std::string groups_text(const Json& groups) {
  if (groups.is_null()) return {};
  const Json& settings = groups.at("group_comparison");
  std::string text = "Groups: mean +- standard deviation of people\n";
  text += settings.at("person_column").is_null()
              ? "  The table has no column subject: each recording counts as a person.\n"
              : "  Recordings with the same " + one_line(settings.at("person_column")) +
                    " are one person's; their mean counts once.\n";
  for (const Json& group : groups.at("groups")) text += group_text(group);
  for (const Json& pair : groups.at("comparisons")) text += pair_text(pair);
  const std::string pairs =
      settings.at("pairs") == 1 ? "" : format(" in %d pairs of groups", settings.at("pairs").get<int>());
  text += format(
      "  %d parameters were compared%s: %d adjusted intervals (Bonferroni), with a joint coverage of at least 95%%.\n",
      settings.at("parameters").get<int>(), pairs.c_str(), settings.at("intervals").get<int>());
  return text + left_out_text(settings.at("left_out"));
}

Json page_groups(const Json& groups, const Json& recordings) {
  if (groups.is_null()) return nullptr;
  Json page = groups;
  page["members"] = Json::array();
  for (const Json& recording : recordings) {
    if (recording.contains("error")) continue;
    const std::string group = recording.value("group", std::string());
    page["members"].push_back(
        {{"group", group}, {"left_out", group.empty() ? std::string() : reason_to_leave_out(recording)}});
  }
  return page;
}

}  // namespace decid::tools
