// One node of a tree of Gaussians: evidence about a location, seen through a deviation of known variance.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace decid::cohort {

/// Evidence exp(b.x - x.A x / 2) about x. A: a lower triangle, row after row (base/math/cholesky.hpp).
struct Evidence {
  explicit Evidence(std::size_t size) : precision(size * (size + 1) / 2, 0.0), shift(size, 0.0) {}
  void clear();
  void add(const Evidence& other);

  std::vector<double> precision, shift;
};

/// Returns row i of A x.
double row_times(std::span<const double> precision, std::size_t i, std::span<const double> x);

/// x = location + d, d ~ N(0, diagonal variances), with evidence about x. `absorb` makes the evidence about the
/// location; `draw` draws d given a location.
class Deviation {
 public:
  explicit Deviation(std::size_t size)
      : size_(size), root_(size * (size + 1) / 2), by_root_(size * size), shifted_(size), work_(size) {}

  /// Prepares draw() and whiten(). evidence: the sum of all pieces.
  void prepare(std::span<const double> sd, const Evidence& evidence);
  /// As prepare(); sets `about_location` to the evidence about the location.
  void absorb(std::span<const double> sd, const Evidence& evidence, Evidence& about_location);
  /// Draws d. shift: b - A location, of the evidence in prepare(); normal: independent deviates.
  void draw(std::span<const double> shift, std::span<const double> normal, std::span<double> d);
  /// Returns half the logarithm of the determinant of d's covariance.
  double log_root_determinant() const;

  /// Sets out (size x size, row after row) to L^-1 A, where L L^t is the precision of d.
  void whiten(const Evidence& evidence, std::span<double> out) const;
  /// Sets out to L^-1 b.
  void whiten(std::span<const double> shift, std::span<double> out) const;

 private:
  std::size_t size_;
  std::vector<double> root_;  ///< L^-1
  std::vector<double> by_root_, shifted_, work_;
};

}  // namespace decid::cohort
