// Calibrated trials as JSON: see calibrated_trials.hpp.
#include "tools/decid/results/calibrated_trials.hpp"

#include <limits>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "sim/protocol/protocol_object.hpp"
#include "tools/report/json/parameters_json.hpp"

namespace decid::tools {
namespace {

Json values_json(const sim::Parameters& values) {
  return std::vector<double>(values.begin(), values.end());
}

/// Reads `count` values. Throws the JSON library's exception for anything else, as for a missing key.
sim::Parameters values_from(const Json& json, std::size_t count) {
  sim::Parameters values(count);
  for (std::size_t p = 0; p < count; ++p) values[p] = json.at(p).get<double>();
  return values;
}

/// Returns the settings in a file in today's form, in which the protocol has the noise's period.
Json settings_of(const Json& calibration, const std::string& file) {
  Json settings = calibration.at("settings");
  Json& protocol = settings.at("protocol");
  protocol = sim::to_json_object(sim::protocol_from_object(protocol, file));
  return settings;
}

/// Returns a setting for a message. Shortens long JSON text in the middle.
std::string shown(const Json& value) {
  constexpr std::size_t most = 40;
  const std::string text = print_json(value);
  return text.size() <= most ? text : text.substr(0, most / 2) + "..." + text.substr(text.size() - most / 4);
}

/// Returns "seed is 9, and was 90" for the first value that differs; empty if none differs. `name`: the value's name.
std::string first_difference(const Json& earlier, const Json& now, const std::string& name) {
  if (earlier == now) return {};
  if (!earlier.is_object() || !now.is_object()) return name + " is " + shown(now) + ", and was " + shown(earlier);
  const std::string prefix = name.empty() ? std::string() : name + ".";
  for (const auto& [key, value] : now.items()) {
    const auto before = earlier.find(key);
    if (before == earlier.end()) return prefix + key + " is " + shown(value) + ", and was not there";
    if (std::string text = first_difference(*before, value, prefix + key); !text.empty()) return text;
  }
  for (const auto& [key, value] : earlier.items())
    if (!now.contains(key)) return prefix + key + " was " + shown(value) + ", and is missing";
  return {};
}

}  // namespace

void require_same_settings(const Json& earlier, const Json& now, const std::string& file) {
  if (const std::string text = first_difference(earlier, now, {}); !text.empty())
    throw Error(Code::file_differs, file, "was written with other settings: " + text,
                "give the same options, or another --output");
}

Json trial_json(const CalibratedTrial& trial) {
  return {{"attempt", trial.attempt},
          {"truth", values_json(trial.truth)},
          {"mean", values_json(trial.mean)},
          {"sd", values_json(trial.stddev)},
          {"below", trial.below},
          {"network", trial.network ? values_json(*trial.network) : Json(nullptr)},
          {"log_score", number_or_null(trial.log_score)},
          {"network_log_score", number_or_null(trial.network_log_score)},
          {"rhat", number_or_null(trial.rhat)},
          {"effective_draws", trial.effective_draws},
          {"agreed", trial.agreed},
          {"seconds", trial.seconds}};
}

CalibratedTrial trial_from(const Json& json, std::size_t parameters) {
  CalibratedTrial trial;
  trial.attempt = json.at("attempt").get<std::uint64_t>();
  trial.truth = values_from(json.at("truth"), parameters);
  trial.mean = values_from(json.at("mean"), parameters);
  trial.stddev = values_from(json.at("sd"), parameters);
  for (std::size_t p = 0; p < parameters; ++p) trial.below.push_back(json.at("below").at(p).get<double>());
  if (json.contains("network") && !json.at("network").is_null())
    trial.network = values_from(json.at("network"), parameters);
  const auto score = [&](const char* key) {
    const auto found = json.find(key);
    return found == json.end() || found->is_null() ? CalibratedTrial::unknown_score : found->get<double>();
  };
  trial.log_score = score("log_score");
  trial.network_log_score = score("network_log_score");
  trial.rhat = json.at("rhat").is_null() ? std::numeric_limits<double>::infinity() : json.at("rhat").get<double>();
  trial.effective_draws = json.at("effective_draws").get<double>();
  trial.agreed = json.at("agreed").get<bool>();
  trial.seconds = json.at("seconds").get<double>();
  return trial;
}

std::vector<CalibratedTrial> earlier_trials(const std::string& file, const Json& settings, const Json& network,
                                            std::size_t parameters) {
  std::vector<CalibratedTrial> trials;
  const Json json = parse_json(read_file(file), file);
  try {
    require_same_settings(settings_of(json, file), settings, file);
    const bool same_network = json.value("network", Json(nullptr)) == network;
    for (const Json& trial : json.at("trials")) {
      trials.push_back(trial_from(trial, parameters));
      if (same_network) continue;
      trials.back().network.reset();
      trials.back().network_log_score = CalibratedTrial::unknown_score;
    }
  } catch (const Json::exception&) {
    throw Error(Code::file_unsupported, file, "is not a calibration", "give the file that decid calibrate -o wrote");
  }
  return trials;
}

}  // namespace decid::tools
