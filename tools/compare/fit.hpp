// Iterative identification: the parameters whose simulated trials are most like a recording. CMA-ES from several starts
// on the simulated likelihood (likelihood.hpp), then population Monte Carlo around the optimum (Cappe et al., J Comp
// Graph Stat 13, 2004) for the mean and the standard error of each parameter.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tools/compare/likelihood.hpp"

namespace decid::iterative {

struct Start {
  sim::Parameters parameters;  ///< SI units, one for each of the table's; taken to the nearest in the ranges
  double spread = 0.3;         ///< first standard deviation of the search, as a fraction of each parameter's range
  /// Standard deviation of a normal prior about `parameters`, as a fraction of each range, for all searches and the
  /// estimate; 0: none. The prior is assumed to come from the same recording, which counts evidence twice; therefore
  /// standard errors are widened.
  double prior = 0.0;
};

/// Returns the middle of all ranges; returns a uniform draw from them.
Start middle_start(const sim::ParameterTable& table);
Start random_start(const sim::ParameterTable& table, std::uint64_t seed, std::uint64_t number);

struct Settings {
  long long simulations = 20'000;  ///< of trials in all, at most; min_simulations(starts) at least
  std::uint64_t seed = 1;          ///< of the search and of the noise it simulates
};
/// Returns the minimum number of simulations of a fit: one generation of each search and the rounds around the optimum.
long long min_simulations(std::size_t starts);
/// Throws Error if the settings allow fewer.
void check_budget(const Settings& settings, std::size_t starts);

struct Result {
  /// Posterior mean of the parameters under a uniform prior over the ranges. It has the minimum expected squared error,
  /// which is also the training criterion of networks.
  sim::Parameters parameters;
  /// Posterior standard deviation of the parameters: a rough standard error. It is 0.29 of the range if the recording
  /// has no information about a parameter.
  sim::Parameters standard_error;
  /// The likeliest parameters found, which fits usually return. Ill-determined ones lie at an edge of their range.
  sim::Parameters likeliest;
  double cost = 0.0;               ///< of the likeliest: minus the logarithm of the likelihood, up to a constant
  double sensor_noise_deg = 0.0;   ///< likeliest level of the white measurement noise; at least 0.0005
  bool stands = false;             ///< false: every trial simulated fell, and the figures mean nothing
  long long simulations = 0;       ///< used
  int start = 0;                   ///< the start whose search found it
  double effective_samples = 0.0;  ///< of the last round's weights: standard errors of few samples are rough
};

/// Deterministic: depends neither on threads nor on other fits. Other machines may give other last bits (Eigen).
/// Throws Error for no start, one without all parameters, too small a budget, and as Likelihood does.
Result fit(const sim::Simulator& simulator, std::span<const float> sway_rad, std::span<const Start> starts,
           const Settings& settings);

}  // namespace decid::iterative
