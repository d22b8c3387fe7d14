// What a model makes of recordings that are not what it expects: fresh trials with one fault each, at stated sizes. How
// far off its estimates are, whether its intervals know, and whether it warns.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identify/studies/calibration.hpp"
#include "identify/studies/fault_trials.hpp"
#include "identify/training/training.hpp"

namespace decid {

/// One row of the table.
struct FaultFigures {
  Fault fault;
  Evaluation errors;                    ///< NaN where no parameters are true
  std::optional<Calibration> promises;  ///< of a model that says how sure it is, where parameters are true
  double warned = 0.0;                  ///< share of the trials with a caution or worse
};

struct FaultStudy {
  std::vector<FaultFigures> rows;
  std::vector<std::string> notes;  ///< what was left out, and why: faults that the protocol cannot have
};

/// A row for each of them, on `trials` fresh valid base trials of `seed`, of the protocol's own body and with so much
/// white noise of the sensor, the same for every fault; but with twice the tilt those that still stand, and of leg and
/// trunk one body with other noise in each. Throws Error if the model was trained on trials of that seed. announce:
/// called with what is done next.
FaultStudy study_faults(const Model& model, double sensor_noise_deg, int trials, std::uint64_t seed,
                        const std::function<void(const std::string&)>& announce);

}  // namespace decid
