// A basis of the vestibular noise: a stationary Gaussian process with the protocol's spectrum, written as harmonics of
// a period longer than the trial, each with two standard normal coefficients.
#pragma once

#include <span>
#include <vector>

#include "base/math/math.hpp"
#include "posterior/kernels/kernels.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::posterior {

/// The noise's velocity at the edges of bins of `bin_s` seconds. Harmonic k of the period represents the band from (k -
/// 1/2) / period to (k + 1/2) / period; its variance is the spectrum's power in this band. The period is at least as
/// long as all edges, and at least 1.2 times the trial. The noise at the trial's start and end is then nearly
/// independent (correlation of the velocity below 2 % for 20 s and 1 Hz).
class NoiseBasis {
 public:
  /// edges: their number; trial_edges: the trial's, at their end. Harmonics above highest_hz are omitted.
  NoiseBasis(const sim::Protocol& protocol, int bin_steps, int edges, int trial_edges, double highest_hz);

  int size() const noexcept { return static_cast<int>(2 * stddevs_.size()); }
  int edges() const noexcept { return edges_; }
  double period_s() const noexcept { return period_s_; }
  /// Returns the frequency of the harmonic that a coefficient belongs to.
  double frequency_hz(int coefficient) const noexcept {
    const int harmonic = first_ + coefficient / 2;  // two coefficients each
    return harmonic / period_s_;
  }

  /// Returns the number of Fourier transforms in a synthesis.
  int transforms() const noexcept { return phases_; }
  int transform_length() const noexcept { return fft_.length(); }

  /// Returns the number of doubles that `work` must hold in the functions below.
  std::size_t work_size() const;
  /// Computes the velocity, rad/s, one value per edge and chain, for Nv = 1; coefficients: size() values per chain.
  void synthesize(const double* coefficients, double* velocity, double* work, Isa isa) const;
  /// Computes derivatives by the coefficients from derivatives by the velocity at each edge.
  void gradient(const double* by_velocity, double* by_coefficient, double* work, Isa isa) const;
  /// Returns the velocity of one coefficient, at all edges.
  void column(int coefficient, std::span<double> velocity) const;

 private:
  /// Parts of `work`: scaled coefficients or their sums, then the transform's work space.
  struct Parts {
    std::span<double> coefficients, spectrum, signal, rest;
  };
  Parts parts(double* work) const;

  int edges_, points_, first_;  // of the period's `points_` bins; first_: number of the first harmonic
  double period_s_;
  std::vector<double> stddevs_;  // of each harmonic, rad/s
  sim::RealFft fft_;             // of points that are `phases_` apart
  int phases_;
  std::vector<double> turns_;  // complex, of phase r and harmonic i at r * harmonics + i
  std::vector<SinCos> turn_;   // in `points_` parts
};

}  // namespace decid::posterior
