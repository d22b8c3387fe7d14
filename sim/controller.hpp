// What the controllers of the single and the double pendulum share: the dead band, the delay line and the bounds of the
// parameters. Not installed.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "base/error.hpp"
#include "sim/protocol/checker.hpp"
#include "sim/simulate.hpp"

namespace decid::sim {

/// x without its part within [-theta, theta]: the definition of f_theta in one subtraction.
template <class Real>
Real dead_band_of(Real x, Real theta) {
  const Real within = x < -theta ? -theta : (x > theta ? theta : x);
  return x - within;
}

/// A delay in steps: whole ones, the fraction beyond, and the first step that is not before it.
struct Lag {
  /// 0 <= delay_s <= longest_delay_s.
  explicit Lag(double delay_s) {
    double steps = delay_s * steps_per_second;
    // A delay of whole milliseconds is one, whatever the rounding of its product.
    const double nearest = std::floor(steps + 0.5);
    if (std::abs(steps - nearest) < 1e-9) steps = nearest;
    whole = static_cast<int>(steps);
    fraction = steps - whole;
    first_step = static_cast<int>(std::ceil(steps));
  }
  int whole, first_step;
  double fraction;
};

/// What was commanded a delay ago: linear between the two neighbouring steps, zero while the trial is younger.
class DelayLine {
 public:
  /// 0 <= delay_s <= longest_delay_s.
  explicit DelayLine(double delay_s) : lag_(delay_s) {}

  /// Takes the command of this step, which is the one returned if there is no delay.
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

/// The protocol, if it is valid and asks for the single pendulum's parameters. Throws Error.
inline Protocol checked(Protocol protocol) {
  protocol.validate();
  if (protocol.experiment.body_model == &single_pendulum()) return protocol;
  throw Error("protocol " + protocol.name, "its body model is '" + protocol.experiment.body_model->name + "'",
              "use the simulator of that; this one has the parameters of the single pendulum");
}

/// Throws Error, where = whose + "parameter Kp", unless all are finite, 0 or above, and the delay is in its bound.
inline void check_parameters(const Parameters& parameters, const std::string& whose = {}) {
  const ParameterTable& table = single_pendulum().parameters;
  if (parameters.size() != table.size()) {
    throw Error(whose + "parameters", std::to_string(parameters.size()) + " values are given",
                "give all " + std::to_string(table.size()));
  }
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double value = parameters[i];
    const double largest = i == Delay ? longest_delay_s : std::numeric_limits<double>::max();
    if (value >= 0.0 && value <= largest) continue;  // false for NaN
    throw Error(whose + "parameter " + table[i].name, "is " + given_text(value),
                i == Delay ? "give a delay from 0 to " + given_text(longest_delay_s) + " s"
                           : "give a finite value, 0 or above");
  }
}

}  // namespace decid::sim
