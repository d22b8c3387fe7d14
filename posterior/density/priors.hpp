// Priors of a recorded trial.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/protocol/protocol.hpp"

namespace decid::posterior {

/// Replaces the uniform prior of a parameter in its table's range. All values are in the table's unit, an SI unit, or
/// over the body's m g h, as the literature gives gains: Kp of 1 is m g h, Kd of 0.3 is 0.3 m g h seconds.
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
  std::optional<double> fixed = {};   ///< the parameter has this value, and is not inferred
  struct OverMgh {
    bool range = false, normal = false, fixed = false;
    bool any() const { return range || normal || fixed; }
  };
  OverMgh over_mgh = {};  ///< which of the values are over m g h; all others are in SI units
};

/// A parameter as users name it: "Kp", or "Kp/mgh" if its values are over m g h. The unit stands in the name, not
/// behind a number, because it holds for both of a pair (--prior Kp/mgh=1,0.2), and because C and Python take names
/// with numbers.
struct PriorName {
  explicit PriorName(const std::string& text);
  std::string parameter;
  bool over_mgh;
};

struct Priors {
  double sensor_noise_deg = 0.02;   ///< median of the white measurement noise, which is log-normal
  double sensor_noise_factor = 20;  ///< two thirds of the distribution lie within this factor of the median
  double slow_ratio = 0.25;         ///< sd of slow over white measurement noise: median, also log-normal
  double slow_ratio_factor = 10;
  /// The recording starts up to this much before or after the protocol, uniform; at most 1; 0: at its start.
  double start_s = 0.1;
  /// Sd of the logarithm of recorded over true sway, which is log-normal about 1; at most 0.9; 0: known.
  double gain = 0.06;
  double drift_hz = 0.03;  ///< the white noise rises below this
  /// The body has stood and swayed this long before the protocol's start; at most 60; 0: it begins at rest.
  double standing_s = 10.0;
  /// The platform played the cycle's end before the protocol's start, also if the protocol says so; else it rested. A
  /// lead-in is rest: with one this has no effect.
  bool moved_before = false;
  std::vector<ParameterPrior> parameters = {};
};

/// A parameter as a function of a standard normal coordinate: the quantile of its prior.
struct Quantile {
  double low, range;            ///< its range; range 0: fixed
  double mean = 0.0, sd = 0.0;  ///< sd 0: uniform
  double probability_low = 0.0,
         probability_range = 1.0;  ///< of the normal distribution: below low, and within the range

  bool operator==(const Quantile&) const = default;

  double value(double x) const;
  /// Returns the derivative of value().
  double slope(double x) const;
  /// As value() and slope(), of a normal prior, as far as 37 of its standard deviations from its mean. value(), whose
  /// bits fits of recordings have, ends at 8.
  double value_in_tails(double x) const;
  double slope_in_tails(double x) const;
  /// Returns the quantile of the prior at a probability, and its derivative.
  double value_at(double probability) const;
  double slope_at(double probability) const;
  /// Returns the coordinate of a value. Values outside of the range, or within a hundredth of probability of its ends,
  /// have the hundredth's coordinate.
  double coordinate(double value) const;
};

/// Returns the names of parameters whose values lie farther than 5 of the normal prior's standard deviations from its
/// mean, joined by commas: there data and prior contradict each other. values: as many as the table has.
std::string contradicted_priors(const std::vector<ParameterPrior>& priors, const sim::ParameterTable& table,
                                std::span<const double> values);

/// Returns the priors with all values in SI units, for the protocol's body. Throws Error for values over m g h of a
/// parameter that does not scale with it.
Priors in_si_units(Priors priors, const sim::Protocol& protocol);
/// Returns a hint for a value of a parameter, in SI units, that may be meant over m g h because it is below a hundredth
/// of the range's end, such as Kp of 1; empty for other values and parameters.
std::string mgh_hint(const sim::ParameterInfo& info, double value);
/// Returns the priors with parameters that have a convention (sim::ParameterInfo) fixed, unless the priors name them.
Priors with_conventions(Priors priors, const sim::ParameterTable& table);
/// Returns the priors. Throws Error for priors out of their bounds.
const Priors& require_valid(const Priors& priors);
/// Returns the table with the priors' ranges. Throws Error for values that are not in SI units, for an unknown or
/// repeated name, and for a range that is empty, negative, not finite or ends above 100 times the table's end. Throws
/// Error for a normal prior with less than a millionth of its probability in the range. Throws Error for a fixed value
/// that cannot be simulated or lies above 100 times the table's end, for one of a gain that may be meant over m g h
/// (mgh_hint()), and for one beside a range or a normal prior.
sim::ParameterTable ranges_for(const Priors& priors, const sim::ParameterTable& table);
/// Returns the quantile function of parameter `name`, which lies in [low, low + range].
Quantile make_quantile(const Priors& priors, const std::string& name, double low, double range);

}  // namespace decid::posterior
