// Weighted points of a population Monte Carlo, their moments, and a Gaussian to draw the next ones from. Private to the
// fit. N: the number of dimensions, or Eigen::Dynamic. Eigen adds in another order for fixed sizes, so that N affects
// the bits.
#pragma once

#include <Eigen/Cholesky>
#include <cstdint>
#include <span>

#include "base/math/random.hpp"
#include "sim/parameters.hpp"

namespace decid::iterative {

inline constexpr int max_dimensions = static_cast<int>(sim::Parameters::most);
template <int N>
inline constexpr int max_rows = N == Eigen::Dynamic ? max_dimensions : N;
template <int N>
using Vector = Eigen::Matrix<double, N, 1, 0, max_rows<N>, 1>;
template <int N>
using Matrix = Eigen::Matrix<double, N, N, 0, max_rows<N>, max_rows<N>>;

template <int N>
Vector<N> to_vector(std::span<const double> values) {
  return Eigen::Map<const Vector<N>>(values.data(), static_cast<Eigen::Index>(values.size()));
}

template <int N>
struct Point {
  Vector<N> unit;  ///< parts of the parameters' ranges
  double cost;
};

/// Mean and covariance of weighted points.
template <int N>
struct Moments {
  explicit Moments(Eigen::Index dimensions)
      : mean(Vector<N>::Zero(dimensions)), covariance(Matrix<N>::Zero(dimensions, dimensions)) {}
  Vector<N> mean;
  Matrix<N> covariance;
};
template <int N>
Moments<N> moments(std::span<const Point<N>> points, std::span<const double> weights) {
  Moments<N> m(points.front().unit.size());
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    m.mean += weights[i] * points[i].unit;
    sum += weights[i];
  }
  m.mean /= sum;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector<N> d = points[i].unit - m.mean;
    m.covariance += weights[i] / sum * d * d.transpose();
  }
  return m;
}

/// A Gaussian truncated to the unit box, to draw points and to weigh them.
template <int N>
class Proposal {
 public:
  /// wider: ratio of the variance to the variance of the points.
  Proposal(const Moments<N>& m, double wider) : mean_(m.mean) {
    const Eigen::Index n = mean_.size();
    // No direction narrower than a thousandth of the ranges: the points it came from may lie in a plane.
    const Matrix<N> covariance = wider * m.covariance + 1e-6 * Matrix<N>::Identity(n, n);
    factor_ = covariance.llt().matrixL();
  }
  /// Returns minus the logarithm of its density, up to a constant.
  double energy(const Vector<N>& unit) const {
    return 0.5 * factor_.template triangularView<Eigen::Lower>().solve(unit - mean_).squaredNorm();
  }
  /// Draws until a point is in the box. The mean is in the box, so at worst one in some hundred points is.
  Vector<N> draw(const Random& random, std::uint64_t& next) const {
    constexpr int tries = 20'000;
    Vector<N> unit = mean_;
    for (int i = 0; i < tries; ++i) {
      Vector<N> normal(mean_.size());
      for (Eigen::Index d = 0; d < normal.size(); ++d) normal[d] = random.normal(next++);
      unit = mean_ + factor_ * normal;
      if (unit.minCoeff() >= 0 && unit.maxCoeff() <= 1) break;
    }
    return unit.cwiseMax(0).cwiseMin(1);
  }

 private:
  Vector<N> mean_;
  Matrix<N> factor_;
};

}  // namespace decid::iterative
