// Fits a mixture of Gaussians to a posterior's draws: expectation and maximisation (A. Dempster, N. Laird, D. Rubin,
// J. R. Stat. Soc. B 39 (1977) 1-38), with the number of components by Schwarz's criterion (Ann. Stat. 6 (1978)
// 461-464). A step of maximisation keeps the draws' mean and covariance.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace decid::cohort {

struct Gaussians {
  std::vector<double> weights;
  std::vector<std::vector<double>> centres, covariances;  ///< covariance: a lower triangle (base/math/cholesky.hpp)
};

inline constexpr std::size_t max_gaussians = 4;

/// Returns one to max_gaussians components. points: draw by draw, all coordinates each; weights: their sum is 1.
/// effective_draws: the number of independent draws that tell as much, for the criterion. Variances are `min_variance`
/// or more. The covariance of one component is singular if all draws are on a plane.
Gaussians fit_gaussians(std::size_t size, std::span<const double> points, std::span<const double> weights,
                        double effective_draws, double min_variance);

}  // namespace decid::cohort
