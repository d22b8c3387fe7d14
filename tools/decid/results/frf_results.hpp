// What `decid fit --frf` reports: the posterior of a published frequency response, and how it explains the table.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/files/json_object.hpp"
#include "posterior/frf/fit.hpp"

namespace decid::tools {

struct FrfReport {
  const frf::Density& density;
  const frf::Fit& found;
  std::optional<sim::Parameters> truth;
  double seconds;
  Json options;
  bool body_assumed;
};

/// The keys of a recording's fit where they mean the same, and "misfit", "frf"; each parameter also has "prior_sd" and
/// "contraction".
std::string frf_fit_json(const FrfReport& report);
std::string frf_fit_text(const FrfReport& report);

/// Arrays: "parameters" (draws x parameters, SI units), "gain", "error" and "chain", a number for each draw.
void write_frf_draws(const std::filesystem::path& path, const FrfReport& report);

}  // namespace decid::tools
