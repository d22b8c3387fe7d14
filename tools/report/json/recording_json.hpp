// Data of a recording that the pages of `decid identify` and `decid fit` share.
#pragma once

#include <cmath>
#include <initializer_list>
#include <optional>
#include <span>

#include "base/files/json_object.hpp"
#include "identify/result.hpp"
#include "tools/report/json/parameters_json.hpp"

namespace decid::tools {

/// Returns {"command", "adds"} of the command that gives another answer to the report's recordings, or null.
Json other_answer_json(const Report& report);

/// Adds in front "decid", the version, and "command", "arguments", "seed" and "inputs" of the call: what decid rerun
/// reads. inputs: "file", and "sha256" or null.
void add_call(Json& json, const Call& call);
/// Returns the call for pages: "command" as one line, "protocol", "inputs".
Json call_json(const Call& call, const std::string& protocol);

/// Returns the errors of recordings that could not be used, one text per recording.
Json errors_json(const Report& report);

/// Returns parameters_json() of the estimate, with "description", "low" and "high" of the range in `table`.
Json described_parameters(const RecordingResult& recording, const sim::Protocol& protocol,
                          const sim::ParameterTable& table);
/// Adds "mean", "sd", "interval50" and "interval90" of a quantity. Found: as in
/// tools/report/json/posterior_results.hpp.
template <class Found>
void add_intervals(Json& json, const Found& found, int quantity) {
  const auto interval = [&](double probability) {
    const double tail = 0.5 * (1.0 - probability);
    return Json{page_number(found.quantile(quantity, tail)), page_number(found.quantile(quantity, 1.0 - tail))};
  };
  json["mean"] = page_number(found.mean(quantity));
  json["sd"] = page_number(found.stddev(quantity));
  json["interval50"] = interval(0.5);
  json["interval90"] = interval(0.9);
}
/// Returns the correlations below the diagonal, row by row; per_unit: 100 for two decimals.
template <class Found>
Json page_correlations(const Found& found, std::size_t parameters, double per_unit = 100.0) {
  Json correlations = Json::array();
  for (std::size_t a = 0; a < parameters; ++a) {
    Json& row = correlations.emplace_back(Json::array());
    for (std::size_t b = 0; b < a; ++b)
      row.push_back(std::round(per_unit * found.correlation(static_cast<int>(a), static_cast<int>(b))) / per_unit);
  }
  return correlations;
}

/// Returns the recording's measured tilt: "column", "delay_s", "correlation", "gain" (null: unknown); null if there is
/// none. number: formats the values.
Json tilt_to_json(const RecordingResult& recording, Json (*number)(double) = page_number);

/// Returns the power of ten that scales values to whole numbers of three to four digits. `widest`: their widest
/// excursion.
double whole_per_unit(double widest);
/// Returns values * per_unit, rounded; null where they are not finite.
Json whole_numbers(std::span<const double> values, double per_unit);
/// Does the same for a smooth curve, in half the text. Each number is the step from the previous one that is not null;
/// the first is the step from 0.
Json whole_steps(std::span<const double> values, double per_unit);

/// Splits the data of a recording. Takes these keys out of `recording`, for tables of all recordings. Leaves the other
/// keys, which the page reads when the user opens the recording (Page::details).
Json taken(Json& recording, std::initializer_list<const char*> keys);

}  // namespace decid::tools
