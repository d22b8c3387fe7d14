// Parts of the pages on recordings: see recording_json.hpp.
#include "tools/report/json/recording_json.hpp"

#include <cmath>
#include <utility>

#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "tools/report/json/parameters_json.hpp"

namespace decid::tools {

/// Figures: docs/guide/fit.md, "Should I use `identify` or `fit`?"
Json other_answer_json(const Report& report) {
  if (!report.network_answers) return nullptr;
  if (report.fit)
    return {{"command", "decid identify"},
            {"adds", "a second opinion within milliseconds, with more than twice the squared error"}};
  return {{"command", "decid fit"},
          {"adds",
           "less than half of the squared error, and intervals that allow for start, drift and noise; about 9 s per "
           "recording"}};
}

namespace {

Json inputs_json(const Call& call) {
  Json list = Json::array();
  for (const InputFile& input : call.inputs)
    list.push_back({{"file", input.file}, {"sha256", input.sha256.empty() ? Json(nullptr) : Json(input.sha256)}});
  return list;
}

}  // namespace

void add_call(Json& json, const Call& call) {
  Json all{{"decid", version},
           {"command", call.command},
           {"arguments", call.arguments},
           {"seed", call.seed ? Json(*call.seed) : Json(nullptr)},
           {"inputs", inputs_json(call)}};
  all.update(json);
  json = std::move(all);
}

Json call_json(const Call& call, const std::string& protocol) {
  std::string text = "decid " + call.command;
  for (const std::string& argument : call.arguments) text += " " + shell_quoted(argument);
  return {{"command", text}, {"protocol", protocol}, {"inputs", inputs_json(call)}};
}

Json errors_json(const Report& report) {
  Json list = Json::array();
  for (const RecordingResult& recording : report.recordings)
    if (recording.error) list.push_back(recording.error->what());
  return list;
}

Json described_parameters(const RecordingResult& recording, const sim::Protocol& protocol,
                          const sim::ParameterTable& table) {
  Json list = parameters_json(table, recording.estimate.parameters, protocol.experiment.body.mgh(), recording.truth,
                              page_number);
  for (std::size_t i = 0; i < table.size(); ++i) {
    list[i]["description"] = table[i].description;
    list[i]["low"] = page_number(table[i].low);
    list[i]["high"] = page_number(table[i].high);
    list[i]["beyond"] = table[i].is_beyond(recording.estimate.parameters[i]);
  }
  return list;
}

Json tilt_to_json(const RecordingResult& recording, Json (*number)(double)) {
  const std::optional<recording::TiltMatch>& tilt = recording.trial.tilt;
  if (!tilt) return nullptr;
  return {{"column", recording.tilt_column},
          {"delay_s", number(tilt->delay_s)},
          {"correlation", number(tilt->correlation)},
          {"gain", number(tilt->gain)}};
}

double whole_per_unit(double widest) {
  return std::pow(10.0, 3 - static_cast<int>(std::floor(std::log10(widest))));
}

Json whole_numbers(std::span<const double> values, double per_unit) {
  Json list = Json::array();
  for (const double value : values) {
    if (std::isfinite(value)) {
      list.push_back(std::llround(value * per_unit));
    } else {
      list.push_back(nullptr);
    }
  }
  return list;
}

Json whole_steps(std::span<const double> values, double per_unit) {
  Json list = Json::array();
  long long last = 0;
  for (const double value : values) {
    if (!std::isfinite(value)) {
      list.push_back(nullptr);
      continue;
    }
    const long long whole = std::llround(value * per_unit);
    list.push_back(whole - last);
    last = whole;
  }
  return list;
}

Json taken(Json& recording, std::initializer_list<const char*> keys) {
  Json part = Json::object();
  for (const char* key : keys) {
    part[key] = std::move(recording.at(key));
    recording.erase(key);
  }
  return part;
}

}  // namespace decid::tools
