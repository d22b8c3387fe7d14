// Measurement noise as an explicit covariance matrix of the blocks, built from its definition in spectrum.hpp: the slow
// and obvious way that tests hold NoiseSpectrum and Density to.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "sim/protocol/experiment.hpp"

namespace decid::test {

/// A symmetric positive definite matrix, row after row; factorized at once.
class DenseGaussian {
 public:
  explicit DenseGaussian(std::vector<double> covariance)
      : size_(static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(covariance.size()))))),
        lower_(std::move(covariance)) {
    for (std::size_t i = 0; i < size_; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = lower_[i * size_ + j];
        for (std::size_t k = 0; k < j; ++k) sum -= lower_[i * size_ + k] * lower_[j * size_ + k];
        lower_[i * size_ + j] = i == j ? std::sqrt(sum) : sum / lower_[j * size_ + j];
      }
    }
  }
  /// L^-1 values, L L^t the covariance.
  std::vector<double> whitened(std::span<const double> values) const {
    std::vector<double> result(values.begin(), values.end());
    for (std::size_t i = 0; i < size_; ++i) {
      for (std::size_t k = 0; k < i; ++k) result[i] -= lower_[i * size_ + k] * result[k];
      result[i] /= lower_[i * size_ + i];
    }
    return result;
  }
  double product(std::span<const double> a, std::span<const double> b) const {
    const std::vector<double> of_a = whitened(a), of_b = whitened(b);
    double sum = 0.0;
    for (std::size_t i = 0; i < size_; ++i) sum += of_a[i] * of_b[i];
    return sum;
  }
  double log_determinant() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < size_; ++i) sum += 2.0 * std::log(lower_[i * size_ + i]);
    return sum;
  }
  /// Minus log p, without the term of 2 pi.
  double misfit(std::span<const double> values) const { return 0.5 * (product(values, values) + log_determinant()); }

 private:
  std::size_t size_;
  std::vector<double> lower_;
};

struct DenseNoise {
  std::size_t blocks;
  double block_s, drift_hz;
  double white, slow, square_of_memory;  ///< as in NoiseLevels
  std::vector<int> missing = {};         ///< blocks of any value

  /// Coefficient k of the orthonormal DCT-II takes this of block m.
  double cosine(std::size_t k, std::size_t m) const {
    const auto count = static_cast<double>(blocks);
    return std::sqrt((k == 0 ? 1.0 : 2.0) / count) *
           std::cos(sim::pi * static_cast<double>(k) * (static_cast<double>(m) + 0.5) / count);
  }
  /// Returns the power of coefficient k, without the offset.
  double power(std::size_t k) const {
    const double hz = static_cast<double>(k) / (2.0 * static_cast<double>(blocks) * block_s);
    const double drift = k == 0 ? 0.0 : drift_hz / hz, corner = 2.0 * sim::pi * hz;
    return white * (1.0 + drift * drift) + slow / (1.0 + corner * corner * square_of_memory);
  }
  /// Returns the covariance of all blocks, where the coefficients from `kept` on have the variance `others`.
  std::vector<double> of_blocks(std::size_t kept, double others) const {
    std::vector<double> covariance(blocks * blocks, 0.0);
    const double sd = 10.0 * sim::rad_per_deg;  // of the offset, of the line from end to end, and of missing blocks
    const auto line = [&](std::size_t m) { return (static_cast<double>(m) + 0.5) / static_cast<double>(blocks) - 0.5; };
    for (std::size_t m = 0; m < blocks; ++m)
      for (std::size_t n = 0; n < blocks; ++n) covariance[m * blocks + n] = sd * sd * (1.0 + line(m) * line(n));
    for (const int m : missing) covariance[static_cast<std::size_t>(m) * (blocks + 1)] += sd * sd;
    std::vector<double> cosines(blocks);
    for (std::size_t k = 0; k < (others > 0.0 ? blocks : kept); ++k) {
      for (std::size_t m = 0; m < blocks; ++m) cosines[m] = cosine(k, m);
      const double variance = k < kept ? power(k) : others;
      for (std::size_t m = 0; m < blocks; ++m)
        for (std::size_t n = 0; n < blocks; ++n) covariance[m * blocks + n] += variance * cosines[m] * cosines[n];
    }
    return covariance;
  }
  std::vector<double> transform(std::size_t kept, std::span<const double> values) const {
    std::vector<double> coefficients(kept, 0.0);
    for (std::size_t k = 0; k < kept; ++k)
      for (std::size_t m = 0; m < blocks; ++m) coefficients[k] += cosine(k, m) * values[m];
    return coefficients;
  }
  /// Returns the density of the first `kept` coefficients.
  DenseGaussian of_coefficients(std::size_t kept) const {
    const std::vector<double> all = of_blocks(kept, 0.0);
    std::vector<double> cosines, half(kept * blocks, 0.0), covariance(kept * kept, 0.0);
    for (std::size_t k = 0; k < kept; ++k)
      for (std::size_t m = 0; m < blocks; ++m) cosines.push_back(cosine(k, m));
    for (std::size_t k = 0; k < kept; ++k) {
      for (std::size_t m = 0; m < blocks; ++m)
        for (std::size_t n = 0; n < blocks; ++n) half[k * blocks + n] += cosines[k * blocks + m] * all[m * blocks + n];
      for (std::size_t j = 0; j <= k; ++j) {
        double& entry = covariance[k * kept + j];
        for (std::size_t n = 0; n < blocks; ++n) entry += half[k * blocks + n] * cosines[j * blocks + n];
        covariance[j * kept + k] = entry;
      }
    }
    return DenseGaussian(std::move(covariance));
  }
  /// The relative error that rounding leaves in what is computed with these matrices.
  double rounding(std::size_t kept) const {
    const double largest = 200.0 * sim::rad_per_deg * sim::rad_per_deg * static_cast<double>(blocks);
    double smallest = power(0);
    for (std::size_t k = 1; k < kept; ++k) smallest = std::min(smallest, power(k));
    return std::numeric_limits<double>::epsilon() * largest / smallest;
  }
};

}  // namespace decid::test
