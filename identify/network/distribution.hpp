// What a network says of a trial's parameters beyond a value of each: how sure it is, and which errors go together.
#pragma once

#include "identify/network/mixture.hpp"
#include "identify/network/recalibration.hpp"
#include "sim/parameters.hpp"

namespace decid {

/// In SI units, over the ranges of a model's parameters; a quantity is a parameter's number, as posterior::Posterior
/// has it. Quantiles, deviations and below() are recalibrated; means, correlations and densities are the network's own.
class ParameterDistribution {
 public:
  ParameterDistribution() = default;  ///< of nothing
  /// mixture: of shares of the table's ranges. Throws Error unless the mixture, and the recalibration if it is known,
  /// are of as many parameters as the table.
  ParameterDistribution(Mixture mixture, const sim::ParameterTable& table, Recalibration recalibration = {});

  std::size_t parameters() const noexcept { return low_.size(); }
  double mean(int quantity) const;
  double deviation(int quantity) const;
  /// 0 < share < 1.
  double quantile(int quantity, double share) const;
  /// The probability that the parameter is below a value: quantile()'s inverse.
  double below(int quantity, double value) const;
  double correlation(int a, int b) const;
  /// Logarithm of the density, of shares of the range: 0 where no more is known than the range. A value outside of the
  /// range counts as at its end.
  double log_density(int quantity, double value) const;
  /// Of all parameters together. Throws Error for another number of values than parameters().
  double log_density(const sim::Parameters& values) const;

  template <class Archive>
  void archive(Archive& a) {
    a(mixture_, low_, range_, recalibration_.levels, recalibration_.deviation_factor);
  }

 private:
  double share_of(std::size_t p, double value) const { return (value - low_[p]) / range_[p]; }

  Mixture mixture_;
  sim::Parameters low_, range_;
  Recalibration recalibration_;
};

}  // namespace decid
