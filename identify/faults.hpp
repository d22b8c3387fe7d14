// What a model makes of recordings that are not what it expects: fresh trials with one fault each, at stated sizes. How
// far off its estimates are, whether its intervals know, and whether it warns.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identify/calibration.hpp"
#include "identify/training/training.hpp"

namespace decid {

/// A fault of the recording, or of what was recorded.
struct Fault {
  std::string name;  ///< a condition's key (sim/conditions.hpp), or one of those that all_faults() adds
  double size;       ///< in the key's unit, that many steps, or 0 where there is nothing to measure
  std::string what;  ///< for people
};

/// One row of the table.
struct FaultFigures {
  Fault fault;
  Evaluation errors;                    ///< NaN where no parameters are true
  std::optional<Calibration> promises;  ///< of a model that says how sure it is, where parameters are true
  double warned = 0.0;                  ///< share of the trials with a caution or worse
};

/// None; each condition at several sizes, with either sign and both kinds of filter in half of the trials each; sway
/// that was detrended; and what is no recording of the protocol: sway backwards, upside down, of twice the tilt, of a
/// body of leg and trunk.
std::vector<Fault> all_faults();

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
