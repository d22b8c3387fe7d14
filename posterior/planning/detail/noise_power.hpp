// Information in the power of the sway that vestibular noise drives. In coordinates in which the measurement noise is
// 1, a recording is nearly normal with covariance K = 1 + J J^t, where a column of J is the sway of one coefficient of
// the vestibular noise. With the response S = J^t K^-1 J, the fraction of the noise that the recording determines, and
// the derivatives J_i by parameter i, the information about two parameters is
//
//   mean_i^t K^-1 mean_j + tr(J_i^t K^-1 J_j S) + tr(J^t K^-1 J_i J^t K^-1 J_j).
//
// Elimination of the noise from Density::information gives the first two terms. The third raises the information about
// the size of a response and lowers that about its phase: noise of unknown phase tells nothing about a delay. In it,
// J_i = J times the relative change of the response at each harmonic. Not installed.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "posterior/density/density.hpp"

namespace decid::posterior {

/// The response S, of pairs of harmonics: its parts that keep and that invert phase.
class KnownNoise {
 public:
  /// inverse_factor: of the information about the noise's coefficients, a lower triangle; variance: of their prior.
  KnownNoise(std::size_t coefficients, double variance, std::span<const double> inverse_factor);

  /// Returns the third term for these relative changes, per parameter and harmonic: a lower triangle.
  std::vector<double> third_term(std::span<const std::vector<sim::Complex>> changes) const;
  /// Returns the second term of a parameter and of the noise's gain, without the noise's relative change by the gain.
  double second_term(const std::vector<sim::Complex>& changes) const;

 private:
  std::size_t harmonics_;
  std::vector<double> diagonal_, keeping_, inverting_;
};

/// Returns the relative change of the noise-driven sway with each of these parameters' fractions of its range, at each
/// harmonic of the vestibular noise. The dead band counts as unchanged.
std::vector<std::vector<sim::Complex>> relative_changes(const Density& density, const sim::Parameters& participant,
                                                        std::span<const std::size_t> parameters);

}  // namespace decid::posterior
