// Have chains converged, and how many independent draws are theirs worth?
// Vehtari, Gelman, Simpson, Carpenter, Bürkner, Bayesian Analysis 16, 2021; Betancourt, arXiv:1604.00695 (energy).
#pragma once

#include <vector>

namespace decid::posterior {

/// One quantity's draws: chain by chain, all of the same length, at least 4 draws.
using ChainDraws = std::vector<std::vector<double>>;

/// The larger of the rank-normalised split R-hat and that of the distances from the median: 1 if the halves of all
/// chains agree in place and spread. Infinite if a chain stands still while others do not; 1 if all values are equal.
double rhat(const ChainDraws& chains);

/// How many independent draws have the variance of these draws' mean (rank-normalised, Geyer's initial monotone
/// sequence of autocorrelations); at most draws * log10(draws).
double effective_draws(const ChainDraws& chains);

/// The smallest over the chains of E (energy[n] - energy[n - 1])^2 / var(energy): below 0.3 the momenta drawn are too
/// small to cross the energies of the distribution. energy: of each transition's start, momentum included.
double energy_fraction(const ChainDraws& energy);

}  // namespace decid::posterior
