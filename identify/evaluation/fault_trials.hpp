// Trials with a fault of the recording, or of the recorded body or stimulus. Tables of them show how good estimates are
// if recordings differ from a model's training.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "recording/trial.hpp"
#include "sim/double_pendulum.hpp"
#include "sim/simulate.hpp"

namespace decid {

/// A fault of the recording, or of the recorded body or stimulus.
struct Fault {
  std::string name;       ///< a condition's key (sim/protocol/conditions.hpp), or one of the names below
  double size = 0.0;      ///< in the unit of the name's end, or 0 where there is nothing to measure
  std::string text = {};  ///< in words
};

/// Returns all faults: none; each condition at several sizes, with either sign and both kinds of filter in half of the
/// trials each; detrended sway. The last ones are not recordings of the protocol: sway backwards, upside down, of twice
/// the tilt, of a body of leg and trunk.
std::vector<Fault> all_faults();

/// Returns faults of recordings of people, one size each: a body at rest at the first sample ("at_rest"), an offset,
/// drift, detrending, coloured noise ("coloured_noise_deg": autoregressive, 0.98 from one sample at 100 Hz to the
/// next), a late start, a wrong gain, coarse steps, a low-pass, 50 samples a second ("rate_hz"), a gap bridged by a
/// straight line ("gap_s"). The last ones are not recordings of the protocol: as in all_faults(), and of another
/// stimulus of the same spectrum, which is the protocol's from 20 s on, followed by its first 20 s ("later_part_s").
std::vector<Fault> faults_of_people();

/// Returns the protocol with the fault, if the fault concerns the tilt or the body's standing, or is a condition.
sim::Protocol with_fault(sim::Protocol protocol, const Fault& fault);

/// Returns the reason why trials of the protocol cannot have the fault; empty: they can.
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

  /// Returns trials first, first + 1, ... of the seed: valid base trials of a stream, in which
  /// parameters that have a convention (sim::ParameterInfo) have its value, or `count` trials of leg and
  /// trunk in which the body stands.
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
