// Trials that are recorded with a fault of the recording, or of what is recorded: for tables of what estimates are
// worth where recordings are not what a model expects.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "recording/trial.hpp"
#include "sim/double_pendulum.hpp"
#include "sim/simulate.hpp"

namespace decid {

/// A fault of the recording, or of what was recorded.
struct Fault {
  std::string name;       ///< a condition's key (sim/protocol/conditions.hpp), or one of the names below
  double size = 0.0;      ///< in the unit of the name's end, or 0 where there is nothing to measure
  std::string what = {};  ///< in words
};

/// None; each condition at several sizes, with either sign and both kinds of filter in half of the trials each; sway
/// that was detrended; and what is no recording of the protocol: sway backwards, upside down, of twice the tilt, of a
/// body of leg and trunk.
std::vector<Fault> all_faults();

/// What recordings of people have, a size each: a body at rest at the first sample ("at_rest"), an offset, drift,
/// detrending, coloured noise ("coloured_noise_deg": autoregressive, 0.98 from one sample at 100 Hz to the next), a
/// late start, a wrong gain, coarse steps, a low-pass, 50 samples a second ("rate_hz"), a gap bridged by a straight
/// line ("gap_s"); and what is no recording of the protocol, as in all_faults().
std::vector<Fault> faults_of_people();

/// Returns the protocol with the fault, where the fault is one of the tilt, of the body's standing or a condition.
sim::Protocol with_fault(sim::Protocol protocol, const Fault& fault);

/// Why trials of the protocol cannot have the fault; empty: they can.
std::string impossible(const sim::Protocol& protocol, const Fault& fault);

/// Makes the trials of one fault; immutable.
class FaultTrials {
 public:
  struct Trials {
    std::vector<recording::Trial> sways;
    std::vector<Warnings> warnings;      ///< of reading each of them
    std::vector<sim::Parameters> truth;  ///< empty where no parameters are true
  };

  /// recorded: the protocol as it is simulated and recorded; protocol: as the trials are read. Both must outlive it.
  /// Throws Error for a tilt that is too large and for a body without segments.
  FaultTrials(const sim::Protocol& protocol, const sim::Protocol& recorded, const Fault& fault, std::uint64_t seed);

  /// Trials first, first + 1, ... of the seed: valid base trials of a stream, or those of so many bodies of leg and
  /// trunk that stand.
  Trials take(int first, int count) const;

 private:
  Trials take_single(int first, int count) const;
  Trials take_double(int first, int count) const;

  const sim::Protocol& protocol_;
  const sim::Protocol& recorded_;
  Fault fault_;
  std::uint64_t seed_;
  std::optional<sim::Simulator> single_;
  std::optional<sim::DoubleSimulator> double_;
};

}  // namespace decid
