// CMA-ES: minimises a function of some numbers by sampling from a Gaussian that adapts its mean and covariance. Source:
// Hansen, "The CMA Evolution Strategy: A Tutorial", arXiv:1604.00772, with its default constants. Bounds: samples
// beyond the unit box are mirrored into it (the function is continued evenly).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tools/compare/streams.hpp"

namespace decid::iterative {

/// One search, a generation at a time by ask() and tell(), so that several searches can be evaluated together.
/// Its results depend only on its arguments; the eigenvectors are Eigen's, so other machines may give other last bits.
class CmaEs {
 public:
  /// Starts at `start`, in the unit box, with standard deviation `sigma` along each axis. population: 0 takes
  /// 4 + 3 ln n. `seed` and `item` name its random numbers. Throws Error for no dimension, a start outside of the box,
  /// sigma <= 0 or a population below 4 (0 apart).
  CmaEs(std::span<const double> start, double sigma, int population, std::uint64_t seed, std::uint64_t item);
  ~CmaEs();
  CmaEs(CmaEs&&) noexcept;

  /// Returns the next generation: the population's points of values in [0, 1], one after the other. Repeated calls
  /// before tell() return the same points.
  const std::vector<double>& ask();
  /// Takes the function's values at them; the smaller the better, NaN is worst. Throws Error unless there is
  /// one per point and they were asked for.
  void tell(std::span<const double> values);

  /// Returns the centre of the search, mirrored into the box: the estimate to take if the function is noisy.
  std::vector<double> mean() const;
  /// Returns the standard deviation of the search along its longest axis.
  double longest_axis() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Returns x mirrored at 0 and 1 until it lies between them: 1.2 -> 0.8, -0.3 -> 0.3, 2.1 -> 0.1.
double mirrored(double x) noexcept;

}  // namespace decid::iterative
