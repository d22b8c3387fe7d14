// The evidence of a recording of a report.
#pragma once

#include <optional>

#include "identify/cohort/measurement.hpp"
#include "identify/result.hpp"

namespace decid::cohort {

/// Returns the evidence of a recording of the report: the draws of its posterior, with normal priors divided out, or
/// the network's distribution. It is about the parameters that were inferred (Report::inferred_parameters()); those
/// that scale with m g h count relative to the recording's own body. Empty for the reasons of WithoutEvidence.
std::optional<Measurement> to_measurement(const RecordingResult& result, const Report& report);

}  // namespace decid::cohort
