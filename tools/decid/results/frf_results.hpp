// The report of `decid fit --frf`: the posteriors of a published frequency response, or least-squares fits, for one or
// several controllers, and how they explain the table.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/files/json_object.hpp"
#include "posterior/frf/comparison.hpp"
#include "posterior/frf/least_squares.hpp"

namespace decid::tools {

/// The answer of one controller.
struct FrfAnswer {
  frf::Density density;
  frf::Fit found;
  frf::RowsLeftOut left_out{};          ///< with several controllers only
  posterior::ComparedModel compared{};  ///< with several controllers only

  const sim::BodyModel& controller() const { return *density.model().protocol().experiment.body_model; }
};

/// The least-squares fit of one controller.
struct LogRatioAnswer {
  frf::Density density;
  frf::PointEstimate found;
};

template <class Answer>
struct FrfReportOf {
  std::vector<Answer> answers;  ///< of each controller; the first one is the call's
  std::optional<sim::Parameters> truth;
  double seconds;
  Json options;
  bool body_assumed;
};
using FrfReport = FrfReportOf<FrfAnswer>;
using LogRatioReport = FrfReportOf<LogRatioAnswer>;

/// Returns the keys of a recording's fit where they mean the same, and "misfit", "frf"; each parameter also has
/// "prior_sd" and "contraction". Several controllers: also the list "controllers".
Json frf_fit_object(const FrfReport& report);
std::string frf_fit_text(const FrfReport& report);

/// Writes the first controller's draws as arrays: "parameters" (draws x parameters, SI units), "gain", "error" and
/// "chain", a number for each draw.
void write_frf_draws(const std::filesystem::path& path, const FrfReport& report);

Json log_ratio_object(const LogRatioReport& report);
std::string log_ratio_text(const LogRatioReport& report);

}  // namespace decid::tools
