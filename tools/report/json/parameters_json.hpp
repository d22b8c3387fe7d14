// Parameters and figures of each parameter as JSON, in the one form that results, pages and studies share.
#pragma once

#include <optional>

#include "base/files/json_object.hpp"
#include "base/warning.hpp"
#include "identify/training/training.hpp"

namespace decid::tools {

/// Returns the number, or null if it is not finite: JSON has no NaN.
Json number_or_null(double value);
/// Returns the value with six significant digits; null if it is not finite.
Json page_number(double value);
/// Returns the text, or null if it is empty.
Json text_or_null(const std::string& text);

/// Returns a list with one object per parameter: name, value, unit, "normalized" (over m g h, null where that has no
/// meaning) and, if the truth is known, "true". number: formats the values; pages round them.
Json parameters_json(const sim::ParameterTable& table, const sim::Parameters& parameters, double mgh,
                     const std::optional<sim::Parameters>& truth, Json (*number)(double) = number_or_null);

/// Returns a list of {"code", "severity", "text"}.
Json warnings_json(const Warnings& warnings);

/// Returns {"Kp": values[0], ...}.
template <class Values>
Json by_parameter(const sim::ParameterTable& table, const Values& values) {
  Json json;
  for (std::size_t p = 0; p < table.size(); ++p) json[table[p].name] = number_or_null(values[p]);
  return json;
}

/// Returns {"mse", "matlab_loss", "mse_per_parameter", "trials"}.
Json evaluation_json(const sim::ParameterTable& table, const Evaluation& evaluation);

}  // namespace decid::tools
