// Calibrated trials as JSON: see calibrated_trials.hpp.
#include "tools/decid/results/calibrated_trials.hpp"

#include <algorithm>
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
  constexpr std::size_t max_length = 40;
  const std::string text = print_json(value);
  return text.size() <= max_length ? text
                                   : text.substr(0, max_length / 2) + "..." + text.substr(text.size() - max_length / 4);
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

/// Throws Error if a file's settings differ from this call's. The error names the first difference, with both values.
void require_same_settings(const Json& earlier, const Json& now, const std::string& file) {
  if (const std::string text = first_difference(earlier, now, {}); !text.empty())
    throw Error(Code::file_differs, file, "was written with other settings: " + text,
                "give the same options, or another --output");
}

// Each of the lists names fields by their JSON keys, in the file's order, for the writer and for the reader.
template <class Of, class Visit>
void visit_parameter(Of& of, const Visit& visit) {
  visit("mse", of.mse);
  visit("predicted_variance", of.predicted_variance);
  visit("network_mse", of.network_mse);
  visit("coverage50", of.coverage50);
  visit("coverage90", of.coverage90);
  visit("distance", of.distance);
}

template <class Of, class Visit>
void visit_figures(Of& found, const Visit& visit) {
  visit("trials", found.trials);
  visit("agreed", found.agreed);
  visit("band", found.band);
  visit("band_of_all", found.band_of_all);
  visit("log_score", found.log_score);
  visit("network_log_score", found.network_log_score);
}

template <class Of, class Visit>
void visit_row(Of& row, const Visit& visit) {
  visit("condition", row.fault.name);
  visit("size", row.fault.size);
  visit("trials", row.trials);
  visit("figures", row.figures);
  visit("usable_figures", row.usable_figures);
  visit("usable", row.usable);
  visit("caution", row.caution);
  visit("not_usable", row.not_usable);
  visit("usable_far_off", row.usable_far_off);
  visit("codes", row.codes);
  visit("from_network", row.from_network);
  visit("mean_s", row.mean_s);
  visit("max_s", row.max_s);
}

struct Writer {
  Json& json;
  const sim::ParameterTable& table;
  void operator()(const char* key, const auto& value) const { json[key] = value; }  // NaN prints as null
  void operator()(const char* key, const std::optional<Calibration>& found) const {
    json[key] = found ? figures_json(table, *found) : Json(nullptr);
  }
};

struct Reader {
  const Json& json;
  const sim::ParameterTable& table;
  void operator()(const char* key, auto& value) const { json.at(key).get_to(value); }
  void operator()(const char* key, double& value) const {
    value = json.at(key).is_null() ? std::numeric_limits<double>::quiet_NaN() : json.at(key).get<double>();
  }
  void operator()(const char* key, std::optional<Calibration>& found) const {
    const Json figures = json.value(key, Json(nullptr));  // files of earlier versions lack some
    if (figures.is_null()) return;
    visit_figures(found.emplace(), Reader{figures, table});
    visit_parameter(found->all, Reader{figures.at("all"), table});
    for (const sim::ParameterInfo& info : table)
      visit_parameter(found->parameters.emplace_back(), Reader{figures.at("parameters").at(info.name), table});
  }
};

}  // namespace

Json figures_json(const sim::ParameterTable& table, const Calibration& found) {
  Json json;
  visit_figures(found, Writer{json, table});
  visit_parameter(found.all, Writer{json["all"], table});
  for (std::size_t p = 0; p < table.size(); ++p)
    visit_parameter(found.parameters[p], Writer{json["parameters"][table[p].name], table});
  return json;
}

Json rows_json(const std::vector<FitConditionFigures>& rows, const sim::ParameterTable& table) {
  Json json = Json::array();
  for (const FitConditionFigures& row : rows) visit_row(row, Writer{json.emplace_back(), table});
  return json;
}

std::vector<FitConditionFigures> rows_from_json(const Json& json, const sim::ParameterTable& table) {
  std::vector<FitConditionFigures> rows;
  for (const Json& row : json.get_ref<const Json::array_t&>()) visit_row(rows.emplace_back(), Reader{row, table});
  return rows;
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

std::vector<FitConditionFigures> earlier_rows(const std::string& file, const Json& settings,
                                              const std::vector<FitCondition>& conditions,
                                              const sim::ParameterTable& table) {
  const Json earlier = parse_json(read_file(file), file);
  if (!earlier.is_object() || !earlier.contains("settings") || !earlier.contains("conditions"))
    throw Error(Code::file_unsupported, file, "is not a table of decid calibrate",
                "give the file that --faults or --conditions wrote");
  require_same_settings(earlier["settings"], settings, file);
  const auto is_of = [](const FitConditionFigures& row, const FitCondition& condition) {
    return row.fault.name == condition.fault.name && row.fault.size == condition.fault.size;
  };
  try {
    std::vector<FitConditionFigures> rows = rows_from_json(earlier["conditions"], table);
    if (rows.size() <= conditions.size() && std::equal(rows.begin(), rows.end(), conditions.begin(), is_of))
      return rows;
  } catch (const Json::exception&) {
    throw Error(Code::file_unsupported, file, "has rows that this version does not read",
                "delete it, or give another --output");
  }
  throw Error(Code::file_differs, file, "has other rows than this call makes", "delete it, or give another --output");
}

}  // namespace decid::tools
