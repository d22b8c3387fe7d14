// Convergence diagnostics of chains, and the number of effective draws. Vehtari, Gelman, Simpson, Carpenter, Bürkner,
// Bayesian Analysis 16, 2021; Betancourt, arXiv:1604.00695 (energy).
#pragma once

#include <span>
#include <vector>

namespace decid::posterior {

/// One quantity's draws: chain by chain, of equal length, at least 4 draws. If one is not finite, R-hat is infinite and
/// no draw is effective.
using ChainDraws = std::vector<std::vector<double>>;

/// Returns the larger of two rank-normalised split R-hats: of the values, and of their distances from the median. It is
/// 1 if the halves of all chains agree in place and spread, and if all values are equal. It is infinite if all chains
/// are constant, at different values.
double rhat(const ChainDraws& chains);

/// Returns the number of independent draws that would have the variance of these draws' mean (rank-normalised, Geyer's
/// initial monotone sequence of autocorrelations); at most draws * log10(draws).
double effective_draws(const ChainDraws& chains);

/// Returns the same for the mean itself, without ranks: what its Monte Carlo error needs.
double mean_effective_draws(const ChainDraws& chains);

/// Returns the effective draws of the 5% and of the 95% quantile, whichever has fewer: those of the indicators of draws
/// in the tail that each one ends.
double tail_effective_draws(const ChainDraws& chains);

/// Returns the smallest E (energy[n] - energy[n - 1])^2 / var(energy) of the chains. Below 0.3 the momenta are too
/// small to cross the energies of the distribution. NaN if a chain's energy does not vary. energy: at each transition's
/// start, momentum included.
double energy_fraction(const ChainDraws& energy);

/// The largest R-hat of chains that are pooled without a caution where no network gives a second answer: in 4 of 15
/// trials of `ic` between this and 1.5 a parameter is beyond 5 standard deviations, below it in 1 of 179
/// (docs/research/people.md).
inline constexpr double max_lone_rhat = 1.1;

/// Up to this R-hat chains agree.
inline constexpr double agreed_rhat = 1.05;

/// Returns true if the R-hat of no quantity is above agreed_rhat and each has at least 100 effective draws; false
/// without quantities.
bool chains_agree(std::span<const double> rhat, std::span<const double> effective_draws);

}  // namespace decid::posterior
