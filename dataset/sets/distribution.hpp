// Distributions of values: mean, standard deviation, extremes and a histogram with predefined bins. Method: Welford,
// Technometrics 4, 1962. The results depend only on the values and their order.
#pragma once

#include <span>
#include <vector>

#include "sim/parameters.hpp"

namespace decid::dataset {

class Distribution {
 public:
  /// Makes `bins` equal bins from low to high; low < high, bins >= 1.
  Distribution(double low, double high, int bins);

  void add(double value);

  long long count() const noexcept { return count_; }
  double mean() const noexcept { return mean_; }  ///< 0 without values, like the three below
  double stddev() const noexcept;                 ///< over N
  double min() const noexcept { return min_; }
  double max() const noexcept { return max_; }

  double low() const noexcept { return low_; }
  double high() const noexcept { return high_; }
  /// Returns the number of values in each bin; `high` itself counts for the last one.
  std::span<const long long> bins() const noexcept { return bins_; }
  long long below() const noexcept { return below_; }  ///< low
  long long above() const noexcept { return above_; }  ///< high

 private:
  double low_, high_;
  std::vector<long long> bins_;
  long long count_ = 0, below_ = 0, above_ = 0;
  double mean_ = 0.0, squares_ = 0.0;  // squares: sum of the squared differences from the mean
  double min_ = 0.0, max_ = 0.0;
};

/// Distributions over a set of trials: each parameter over its range, and the noise-free sway's peak-to-peak value.
struct TrialDistributions {
  TrialDistributions() = default;  ///< without parameters
  explicit TrialDistributions(const sim::ParameterTable& table);
  void add(const sim::Parameters& values, double peak_to_peak_rad);

  std::vector<Distribution> parameters;  ///< of 20 bins each
  Distribution peak_to_peak{0.0, 0.175,
                            35};  ///< rad: 35 bins of 0.005 up to 0.175, beyond the 10 degrees of a valid trial
};

}  // namespace decid::dataset
