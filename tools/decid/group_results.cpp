// Groups compared as JSON and text: see group_results.hpp.
#include "tools/decid/group_results.hpp"

#include <map>

#include "base/json_object.hpp"
#include "base/text.hpp"
#include "identify/groups.hpp"
#include "tools/report/parameters_json.hpp"

namespace decid::tools {
namespace {

/// Of each parameter.
using Samples = std::vector<GroupSample>;

Samples samples_of(const std::vector<const Json*>& recordings, std::size_t parameters) {
  Samples samples;
  for (std::size_t p = 0; p < parameters; ++p) {
    std::vector<double> values;
    for (const Json* recording : recordings) values.push_back(recording->at("parameters").at(p).at("value"));
    samples.push_back(group_sample(values));
  }
  return samples;
}

Json comparison_json(const Samples& first, const Samples& second, const sim::ParameterTable& parameters) {
  Json list = Json::array();
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const GroupEffect effect = group_effect(first[p], second[p]);
    list.push_back({{"name", parameters[p].name},
                    {"difference", number_or_null(effect.difference)},
                    {"hedges_g", number_or_null(effect.g)},
                    {"interval95", {number_or_null(effect.low), number_or_null(effect.high)}}});
  }
  return list;
}

std::string number_text(const Json& value, const char* pattern) {
  if (!value.is_number()) return "-";
  char text[64];
  std::snprintf(text, sizeof text, pattern, value.get<double>());
  return text;
}

}  // namespace

Json groups_json(Json& recordings, const std::vector<std::string>& groups, const sim::ParameterTable& parameters) {
  std::map<std::string, std::vector<const Json*>> members;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    if (groups.at(i).empty()) continue;
    Json& recording = recordings[i];
    recording["group"] = groups[i];
    std::vector<const Json*>& group = members[groups[i]];
    if (recording.contains("parameters") && recording.at("trust") != "not usable") group.push_back(&recording);
  }
  std::vector<std::pair<std::string, Samples>> samples;
  Json json{{"groups", Json::array()}, {"comparisons", Json::array()}};
  for (const auto& [name, recorded] : members) {
    samples.emplace_back(name, samples_of(recorded, parameters.size()));
    Json list = Json::array();
    for (std::size_t p = 0; p < parameters.size(); ++p) {
      const GroupSample& sample = samples.back().second[p];
      list.push_back({{"name", parameters[p].name},
                      {"mean", number_or_null(sample.mean)},
                      {"sd", number_or_null(sample.deviation)}});
    }
    json["groups"].push_back({{"name", name}, {"recordings", recorded.size()}, {"parameters", std::move(list)}});
  }
  for (std::size_t a = 0; a < samples.size(); ++a)
    for (std::size_t b = a + 1; b < samples.size(); ++b)
      json["comparisons"].push_back(
          {{"groups", {samples[a].first, samples[b].first}},
           {"parameters", comparison_json(samples[a].second, samples[b].second, parameters)}});
  return json;
}

std::string groups_text(const Json& groups) {
  if (groups.is_null()) return {};
  std::string text = "Groups: mean +- deviation of the recordings that can be used\n";
  for (const Json& group : groups.at("groups")) {
    text += "  " + one_line(group.at("name")) + ": " + counted(group.at("recordings"), "recording") + "\n";
    for (const Json& parameter : group.at("parameters"))
      text +=
          format("    %-8s %12s +- %s\n", parameter.at("name").get<std::string>().c_str(),
                 number_text(parameter.at("mean"), "%.5g").c_str(), number_text(parameter.at("sd"), "%.3g").c_str());
  }
  for (const Json& comparison : groups.at("comparisons")) {
    text += "  " + one_line(comparison.at("groups").at(0)) + " less " + one_line(comparison.at("groups").at(1)) +
            ": difference, Hedges' g with its 95 % interval\n";
    for (const Json& parameter : comparison.at("parameters"))
      text += format("    %-8s %12s %8s  %s to %s\n", parameter.at("name").get<std::string>().c_str(),
                     number_text(parameter.at("difference"), "%.4g").c_str(),
                     number_text(parameter.at("hedges_g"), "%.2f").c_str(),
                     number_text(parameter.at("interval95").at(0), "%.2f").c_str(),
                     number_text(parameter.at("interval95").at(1), "%.2f").c_str());
  }
  return text;
}

Json page_groups(const Json& groups, const Json& recordings) {
  if (groups.is_null()) return nullptr;
  Json page = groups;
  page["members"] = Json::array();
  for (const Json& recording : recordings)
    if (recording.contains("parameters")) page["members"].push_back(recording.value("group", std::string()));
  return page;
}

}  // namespace decid::tools
