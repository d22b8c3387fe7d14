// What `decid compare` prints and shows of a comparison of methods.
#pragma once

#include <string>

#include "base/files/json.hpp"
#include "identify/studies/comparison.hpp"

namespace decid::tools {

/// Keys: version, model, weights_sha256, trials_from, protocol, sensor_noise_deg, trials, threads, budget, starts,
/// methods: for each name, description, mse, mse_standard_error, mse_per_parameter, error_per_standard_error (or null),
/// simulations, seconds (both a trial).
Json comparison_json(const ComparisonFigures& figures);
/// comparison_json()'s as a Markdown table, a line for each method.
std::string comparison_text(const Json& comparison, const sim::ParameterTable& table);
/// The JSON file that `decid compare -o` wrote. Throws Error if it is not one, of these parameters.
Json read_comparison(const std::string& file, const sim::ParameterTable& table);
/// The page, self-contained.
std::string comparison_html(const ComparisonFigures& figures);

}  // namespace decid::tools
