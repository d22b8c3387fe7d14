// Tests a model on recordings that differ from its training: test trials with one fault each, at stated sizes. Measures
// the errors of its estimates, the coverage of its intervals, and the fraction of trials with a warning.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identify/evaluation/calibration.hpp"
#include "identify/evaluation/fault_trials.hpp"
#include "identify/training/training.hpp"

namespace decid {

/// One row of the table.
struct FaultFigures {
  Fault fault;
  Evaluation errors;                       ///< NaN where no parameters are true
  std::optional<Calibration> calibration;  ///< if the model gives distributions, where parameters are true
  double warned = 0.0;                     ///< fraction of the trials with a caution or worse
};

struct FaultStudy {
  std::vector<FaultFigures> rows;
  std::vector<std::string> notes;  ///< faults that were left out because the protocol cannot have them, and why
};

/// Computes a row for each fault, on `trials` valid base trials of `seed`, of the protocol's own body and with white
/// measurement noise of `sensor_noise_deg`. The trials are the same for every fault, with two exceptions. With twice
/// the tilt only trials that still stand count; with leg and trunk all trials have one body and different noise. Throws
/// Error if the model was trained on trials of that seed. announce: called with the name of the next step.
FaultStudy study_faults(const Model& model, double sensor_noise_deg, int trials, std::uint64_t seed,
                        const std::function<void(const std::string&)>& announce);

}  // namespace decid
