// Draws from a posterior with ridges and edges whose density and information are cheap. Sequential Monte Carlo moves a
// population from the prior to the posterior in stages, as the likelihood's power rises from 0 to 1 (Del Moral, Doucet,
// Jasra, J. Royal Statistical Society B 68, 2006), so that it finds all relevant regions. Some particles then continue
// as chains. Proposals follow the local information in size and direction, with and without the gradient's drift
// (manifold MALA; Girolami and Calderhead, J. Royal Statistical Society B 73, 2011). Their lengths come from a wide
// range, so that nothing needs tuning.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace decid::frf {

struct SmcSettings {
  std::uint64_t seed = 1;
  int population = 256;
  int stage_transitions = 8;      ///< of each particle at every power; a power keeps half of the population effective
  int settling_transitions = 40;  ///< at the last power
  int chains = 16;                ///< number of chains
  int thinning = 20;              ///< transitions per draw
  int min_draws = 80;             ///< of each chain; rounds repeat while the draws are insufficient
  int max_draws = 1280;
  double max_rhat = 1.01;         ///< sufficient: every coordinate's R-hat is at most this
  double effective_draws = 1000;  ///< sufficient: every coordinate has this many
};

/// The likelihood around a point.
struct Local {
  /// Minus its logarithm; infinite for impossible points, whose other values are ignored.
  double misfit = 0.0;
  std::vector<double> gradient;     ///< of the misfit
  std::vector<double> information;  ///< about the coordinates; lower triangle, row after row
};
/// Sets all of `local`. Gradient and information may be approximate: they guide the proposals without changing the
/// distribution. Any thread may call it.
using Evaluate = std::function<void(std::span<const double> x, Local& local)>;

struct SmcResult {
  std::vector<std::vector<double>> chains;  ///< per chain, draw by draw, `size` coordinates
  std::vector<double> rhat, effective;      ///< of each coordinate
  double acceptance = 0.0;                  ///< fraction of the chains' accepted proposals
  int stages = 0;                           ///< powers of the likelihood
  long long evaluations = 0;
};

/// Draws from exp(-misfit) times the prior of `size` coordinates: the first `uniform` are uniform from 0 to 1, the
/// others standard normal. The result depends only on the settings, not on the threads. Throws Error for settings that
/// are too small, and if 1000 consecutive draws from the prior are impossible.
SmcResult sample_smc(std::size_t size, std::size_t uniform, const Evaluate& evaluate, const SmcSettings& settings);

}  // namespace decid::frf
