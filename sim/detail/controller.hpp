// Shared parts of the single and the double pendulum's controllers: the dead band, the delay line and the bounds of the
// parameters. Not installed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "base/error.hpp"
#include "sim/protocol/detail/checker.hpp"
#include "sim/simulate.hpp"

namespace decid::sim {

/// Returns x without its part within [-theta, theta]: f_theta by a single subtraction.
template <class Real>
Real apply_dead_band(Real x, Real theta) {
  const Real within = x < -theta ? -theta : (x > theta ? theta : x);
  return x - within;
}

/// A delay in steps: whole steps, the fraction beyond, and the first step at or after it.
struct Lag {
  /// Requires 0 <= delay_s <= longest_delay_s.
  explicit Lag(double delay_s) {
    double steps = delay_s * steps_per_second;
    // A delay of whole milliseconds stays whole in spite of rounding.
    const double nearest = std::floor(steps + 0.5);
    if (std::abs(steps - nearest) < 1e-9) steps = nearest;
    whole = static_cast<int>(steps);
    fraction = steps - whole;
    first_step = static_cast<int>(std::ceil(steps));
  }
  int whole, first_step;
  double fraction;
};

/// The command from one delay ago: linear between the two neighbouring steps, zero before the trial's start.
class DelayLine {
 public:
  /// Requires 0 <= delay_s <= longest_delay_s.
  explicit DelayLine(double delay_s) : lag_(delay_s) {}

  /// Stores the command of this step, and returns the delayed one; without delay they are the same.
  double pass(int step, double value) {
    const auto now = static_cast<unsigned>(step);
    ring_[now % slots] = value;
    if (step < lag_.first_step) return 0.0;
    const auto whole = static_cast<unsigned>(lag_.whole);
    const double newer = ring_[(now - whole) % slots];
    const double older = ring_[(now - whole - 1) % slots];
    return newer + lag_.fraction * (older - newer);
  }

 private:
  static constexpr unsigned slots = 1024;  // a power of two, so that the index may wrap
  static_assert(longest_delay_s * steps_per_second + 2 <= slots);
  std::array<double, slots> ring_{};
  Lag lag_;
};

/// Returns the protocol if it is valid and its body model can be simulated. Throws Error.
inline Protocol checked(Protocol protocol) {
  protocol.validate();
  if (!protocol.family().terms.empty()) return protocol;
  throw Error(Code::not_supported, "protocol " + protocol.name,
              "its body model '" + protocol.experiment.body_model->name + "' has only a table",
              "use that model's simulator; this one needs the coefficients of a servo behind a dead band");
}

/// Throws Error, where = whose + "parameter Kp", unless all values are finite and within the table's allowed values.
inline void check_parameters(const Parameters& parameters, const ParameterTable& table, const std::string& whose = {}) {
  if (parameters.size() != table.size()) {
    throw Error(Code::size_mismatch, whose + "parameters", "has " + std::to_string(parameters.size()) + " values",
                "give all " + std::to_string(table.size()));
  }
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double value = parameters[i];
    const double max = std::min(table[i].max, std::numeric_limits<double>::max());
    if (value >= table[i].min && value <= max) continue;  // false for NaN
    throw Error(Code::setting_out_of_range, whose + "parameter " + table[i].name, "is " + given_text(value),
                std::isfinite(table[i].max) ? "give " + given_text(table[i].min) + " to " + given_text(max) +
                                                  (table[i].unit == "1" ? "" : " " + table[i].unit)
                                            : "give a finite value, " + given_text(table[i].min) + " or above");
  }
}

}  // namespace decid::sim
