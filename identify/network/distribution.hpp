// The distribution of a trial's parameters that a network gives: its uncertainty, and correlations of its errors.
#pragma once

#include "identify/network/mixture.hpp"
#include "identify/network/recalibration.hpp"
#include "sim/parameters.hpp"

namespace decid {

/// Distribution in SI units, over the ranges of a model's parameters. A quantity is a parameter's number, as in
/// posterior::Posterior. Quantiles, standard deviations and below() are recalibrated; means, correlations and densities
/// are the network's own.
class ParameterDistribution {
 public:
  ParameterDistribution() = default;  ///< empty
  /// mixture: over fractions of the table's ranges. Throws Error unless the mixture, and the recalibration if it is not
  /// empty, have as many parameters as the table.
  ParameterDistribution(Mixture mixture, const sim::ParameterTable& table, Recalibration recalibration = {});

  std::size_t parameters() const noexcept { return low_.size(); }
  const Mixture& mixture() const noexcept { return mixture_; }
  double low(std::size_t parameter) const { return low_[parameter]; }
  double range(std::size_t parameter) const { return range_[parameter]; }
  const Recalibration& recalibration() const noexcept { return recalibration_; }
  double mean(int quantity) const;
  double stddev(int quantity) const;
  /// Returns the quantile of this probability, 0 < probability < 1.
  double quantile(int quantity, double probability) const;
  /// Returns the probability that the parameter is below a value: the inverse of quantile().
  double below(int quantity, double value) const;
  double correlation(int a, int b) const;
  /// Returns the logarithm of the density over fractions of the range; it is 0 for a uniform distribution. A value
  /// outside of the range counts as its end.
  double log_density(int quantity, double value) const;
  /// Returns the joint log density of all parameters. Throws Error for another number of values than parameters().
  double log_density(const sim::Parameters& values) const;

  template <class Archive>
  void archive(Archive& a) {
    a(mixture_, low_, range_, recalibration_.levels, recalibration_.stddev_factor);
  }

 private:
  double fraction_of(std::size_t p, double value) const { return (value - low_[p]) / range_[p]; }

  Mixture mixture_;
  sim::Parameters low_, range_;
  Recalibration recalibration_;
};

}  // namespace decid
