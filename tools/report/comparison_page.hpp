// The output of `decid compare` on a comparison of methods: JSON, text and page.
#pragma once

#include <string>

#include "base/files/json.hpp"
#include "identify/evaluation/comparison.hpp"
#include "identify/result.hpp"

namespace decid::tools {

/// Keys: version, model, weights_sha256, trials_from, protocol, sensor_noise_deg, trials, threads, budget, starts,
/// methods: for each name, description, mse, mse_standard_error, mse_per_parameter, error_per_standard_error (or null),
/// simulations, seconds (both a trial).
Json comparison_json(const ComparisonFigures& figures);
/// Returns the same as a Markdown table, with one line per method.
std::string comparison_text(const ComparisonFigures& figures);
/// Reads the JSON file that `decid compare -o` wrote; protocol: of the model, which says what the file does not. Throws
/// Error if it is not one, of its parameters.
ComparisonFigures read_comparison(const std::string& file, const sim::Protocol& protocol);
/// Returns the self-contained page.
std::string comparison_html(const ComparisonFigures& figures, const Call& call);

}  // namespace decid::tools
