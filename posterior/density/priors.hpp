// Priors of a recorded trial.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/parameters.hpp"

namespace decid::posterior {

/// Replaces the uniform prior of a parameter in its table's range.
struct ParameterPrior {
  struct Range {
    double low, high;
  };
  struct Normal {
    double mean, sd;
  };
  std::string name;                   ///< as in the parameter table
  std::optional<Range> range = {};    ///< empty: the table's
  std::optional<Normal> normal = {};  ///< within the range; empty: uniform
};

struct Priors {
  double sensor_noise_deg = 0.02;   ///< white measurement noise: median of a log-normal distribution
  double sensor_noise_factor = 20;  ///< two thirds of it lie within this factor of the median
  double slow_ratio = 0.25;         ///< standard deviation of slow over white measurement noise: median, log-normal too
  double slow_ratio_factor = 10;
  double start_s = 0.1;       ///< the recording starts so long after the protocol, uniform in +-, to 1; 0: known
  double gain = 0.06;         ///< recorded over true sway is log-normal about 1 with this standard deviation of
                              ///< the logarithm, to 0.9; 0: known
  double drift_hz = 0.03;     ///< below this the white noise rises
  double standing_s = 10.0;   ///< the body has stood and swayed so long before the protocol's start, to 60; 0: it
                              ///< begins at rest
  bool moved_before = false;  ///< the platform played the cycle's end before the protocol's start; else it rested
  std::vector<ParameterPrior> parameters = {};
};

/// A parameter as a function of a standard normal coordinate: the quantile of its prior.
struct Quantile {
  double low, range;            ///< where it may lie
  double mean = 0.0, sd = 0.0;  ///< sd 0: uniform
  double probability_low = 0.0,
         probability_range = 1.0;  ///< of the normal distribution: below low, and within the range

  double value(double x) const;
  /// The derivative of value().
  double slope(double x) const;
  /// The coordinate of a value; one outside of the range, or within a hundredth of probability of its ends, has the
  /// hundredth's.
  double coordinate(double value) const;
};

/// Throws Error for priors out of their bounds.
const Priors& checked(const Priors& priors);
/// The table with the priors' ranges. Throws Error for a name that it does not have or that stands twice, a range that
/// is empty, negative, not finite or ends above 100 times the table's end, or a normal prior that has less than a
/// millionth of its probability in the range.
sim::ParameterTable ranges_of(const Priors& priors, const sim::ParameterTable& table);
/// Returns the quantile function of parameter `name`, which lies in [low, low + range].
Quantile quantile_of(const Priors& priors, const std::string& name, double low, double range);

}  // namespace decid::posterior
