// The uncertainty that a planned recording will leave, without a recording and without sampling: protocols can be
// compared before a study. Each draw of the priors is a person, with vestibular noise. The Fisher information of a
// recording of this person, with noise, start and gain unknown, gives the posterior's variance. Its mean over the
// participants is the expected posterior variance (K. Chaloner, I. Verdinelli, Stat. Sci. 10 (1995) 273-304).
//
//   const posterior::Density density(protocol, {});
//   const posterior::ExpectedPosterior found = posterior::expected_posterior(density, {.sensor_noise_deg = 0.02});
//   use(found.sd[sim::Kp], found.figure_of_merit);
//
// With the information L about the fractions of the parameters' ranges, a person at u0 has an estimate from
// N(u0, L^-1), and a posterior N(estimate, L^-1) within the ranges (bounded_normal.hpp). The information is that of
// Density::information with the vestibular noise eliminated, and the part that is in the power of the noise-driven sway
// (noise_power.hpp).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "posterior/density/density.hpp"

namespace decid::posterior {

struct PlannedRecordings {
  int draws = 128;                 ///< participants; a multiple of `lanes` is fastest
  double sensor_noise_deg = 0.02;  ///< white measurement noise
  /// The participants' inferred parameters; empty: draws of the priors. A value closer to an end than 1% of its range
  /// is moved there.
  std::optional<sim::Parameters> at = {};
  std::optional<sim::Parameters> participant_sd = {};  ///< with `at`: participants differ by this, within the ranges
  std::uint64_t seed = 1;
};

struct ExpectedPosterior {
  std::vector<double> sd;                  ///< per parameter: root of the expected posterior variance, SI units
  std::vector<double> prior_sd;            ///< per parameter: before the recording
  std::vector<double> relative_variance;   ///< per parameter: expected over prior variance; 0 for a fixed parameter
  double figure_of_merit = 0.0;            ///< mean of relative_variance over the inferred parameters
  double figure_error = 0.0;               ///< its standard error from the number of draws
  std::optional<sim::Parameters> at = {};  ///< if the plan gives one: the values planned for, fixed ones included
};

/// Returns what a recording of the density's protocol leaves. The result does not depend on threads. Throws Error for
/// no draws, a measurement noise that is not above 0, `at` outside of the ranges, `at` or `participant_sd` of another
/// size, priors that fix every parameter, and if 1,000 participants in a row fall.
ExpectedPosterior expected_posterior(const Density& density, const PlannedRecordings& planned);

}  // namespace decid::posterior
