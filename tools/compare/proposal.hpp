// Weighted points of a population Monte Carlo, their moments, and a Gaussian to draw the next ones from. Private to the
// fit.
#pragma once

#include <Eigen/Cholesky>
#include <cstdint>
#include <span>

#include "base/math/random.hpp"

namespace decid::iterative {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

inline Vector to_vector(std::span<const double> values) {
  return Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
}

struct Point {
  Vector unit;  ///< parts of the parameters' ranges
  double cost;
};

/// Mean and covariance of weighted points.
struct Moments {
  explicit Moments(Eigen::Index dimensions)
      : mean(Vector::Zero(dimensions)), covariance(Matrix::Zero(dimensions, dimensions)) {}
  Vector mean;
  Matrix covariance;
};
inline Moments moments(std::span<const Point> points, std::span<const double> weights) {
  Moments m(points.front().unit.size());
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    m.mean += weights[i] * points[i].unit;
    sum += weights[i];
  }
  m.mean /= sum;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector d = points[i].unit - m.mean;
    m.covariance += weights[i] / sum * d * d.transpose();
  }
  return m;
}

/// A Gaussian truncated to the unit box, to draw points and to weigh them.
class Proposal {
 public:
  /// wider: ratio of the variance to the variance of the points.
  Proposal(const Moments& m, double wider) : mean_(m.mean) {
    const Eigen::Index n = mean_.size();
    // No direction narrower than a thousandth of the ranges: the points it came from may lie in a plane.
    const Matrix covariance = wider * m.covariance + 1e-6 * Matrix::Identity(n, n);
    factor_ = covariance.llt().matrixL();
  }
  /// Returns minus the logarithm of its density, up to a constant.
  double energy(const Vector& unit) const {
    return 0.5 * factor_.triangularView<Eigen::Lower>().solve(unit - mean_).squaredNorm();
  }
  /// Draws until a point is in the box. The mean is in the box, so at worst one in some hundred points is.
  Vector draw(const Random& random, std::uint64_t& next) const {
    constexpr int tries = 20'000;
    Vector unit = mean_;
    for (int i = 0; i < tries; ++i) {
      Vector normal(mean_.size());
      for (Eigen::Index d = 0; d < normal.size(); ++d) normal[d] = random.normal(next++);
      unit = mean_ + factor_ * normal;
      if (unit.minCoeff() >= 0 && unit.maxCoeff() <= 1) break;
    }
    return unit.cwiseMax(0).cwiseMin(1);
  }

 private:
  Vector mean_;
  Matrix factor_;
};

}  // namespace decid::iterative
