// Vestibular noise as unknowns: a stationary Gaussian process with the protocol's spectrum, written as harmonics of a
// period longer than the trial, each with two standard normal coefficients.
#pragma once

#include <span>
#include <vector>

#include "base/math/math.hpp"
#include "posterior/kernels/kernels.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::posterior {

/// The noise's velocity at the edges of bins of `bin_s` seconds. Harmonic k of the period stands for the band from
/// (k - 1/2) / period to (k + 1/2) / period: its variance is the power that the spectrum has there. The period is at
/// least 1.2 times the trial, so that the noise at its start and at its end are as independent as those of a process
/// without a period (correlation of the velocity below 2 % for 20 s and 1 Hz), and at least as long as all edges.
class NoiseBasis {
 public:
  /// edges: how many; trial_edges: of the trial at their end. Harmonics above highest_hz are left out.
  NoiseBasis(const sim::Protocol& protocol, int bin_steps, int edges, int trial_edges, double highest_hz);

  int size() const noexcept { return static_cast<int>(2 * deviations_.size()); }
  int edges() const noexcept { return edges_; }
  double period_s() const noexcept { return period_s_; }

  /// A synthesis has so many Fourier transforms, of this length.
  int transforms() const noexcept { return phases_; }
  int transform_length() const noexcept { return fft_.length(); }

  /// Doubles that `work` of the functions below must hold.
  std::size_t work_size() const;
  /// coefficients: size() values a chain; velocity: a value an edge and chain, rad/s, of noise with Nv = 1.
  void synthesize(const double* coefficients, double* velocity, double* work, Isa isa) const;
  /// by_coefficient: from derivatives by the velocity at each edge.
  void gradient(const double* by_velocity, double* by_coefficient, double* work, Isa isa) const;
  /// The velocity that belongs to one coefficient, at all edges.
  void column(int coefficient, std::span<double> velocity) const;

 private:
  /// Of `work`: scaled coefficients or their sums, then what a transform needs.
  struct Parts {
    std::span<double> coefficients, spectrum, signal, rest;
  };
  Parts parts(double* work) const;

  int edges_, points_, first_;  // of the period's `points_` bins; first_: number of the first harmonic
  double period_s_;
  std::vector<double> deviations_;  // of each harmonic, rad/s
  sim::RealFft fft_;                // of the points that are `phases_` apart
  int phases_;
  std::vector<double> turns_;  // complex, of phase r and harmonic i at r * harmonics + i
  std::vector<SinCos> turn_;   // in `points_` parts
};

}  // namespace decid::posterior
