// Iterative identification: the parameters whose simulated trials are most like a recording. CMA-ES from several starts
// on the simulated likelihood (likelihood.hpp), then population Monte Carlo around the optimum (Cappe et al., J Comp
// Graph Stat 13, 2004) for the mean and the standard error of each parameter.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "identify/iterative/likelihood.hpp"

namespace decid::iterative {

struct Start {
  sim::Parameters parameters;  ///< SI units, one for each of the table's; taken to the nearest in the ranges
  double spread = 0.3;         ///< first standard deviation of the search, as part of each parameter's range
  /// Standard deviation, likewise, of a normal prior about `parameters` for all searches and the estimate; 0: none. It
  /// is taken to come from the same recording: standard errors are widened, as evidence is counted twice.
  double prior = 0.0;
};

/// The middle of all ranges; a uniform draw from them.
Start middle_start(const sim::ParameterTable& table);
Start random_start(const sim::ParameterTable& table, std::uint64_t seed, std::uint64_t number);

struct Settings {
  long long simulations = 20'000;  ///< of trials in all, at most; min_simulations(starts) at least
  std::uint64_t seed = 1;          ///< of the search and of the noise it simulates
};
/// The fewest that a fit needs: a generation of each search and the rounds around the optimum.
long long min_simulations(std::size_t starts);
/// Throws Error if the settings allow fewer.
void check_budget(const Settings& settings, std::size_t starts);

struct Result {
  /// Mean of the parameters given the recording, all values in the ranges being equally likely beforehand: of all
  /// estimates it has the least expected squared error, which is also what networks are trained for.
  sim::Parameters parameters;
  /// Standard deviation of the parameters given the recording: a rough standard error. That of a parameter about which
  /// the recording says nothing is 0.29 of its range.
  sim::Parameters standard_error;
  /// The likeliest parameters found: what a fit usually returns. Ill-determined ones lie at an edge of their range.
  sim::Parameters likeliest;
  double cost = 0.0;               ///< of the likeliest: minus the logarithm of the likelihood, up to a constant
  double sensor_noise_deg = 0.0;   ///< white noise of the recording, likeliest level; from 0.0005
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
