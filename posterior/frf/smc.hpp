// Draws from a posterior whose density and information are cheap, with ridges and edges. A population is brought from
// the prior to the posterior in stages, the likelihood's power rising from 0 to 1 (sequential Monte Carlo; Del Moral,
// Doucet, Jasra, J. Royal Statistical Society B 68, 2006), so that it finds the places that count; then some of it go
// on as chains. All move by jumps of the size and direction that the information at their place says, with and without
// the gradient's drift (manifold MALA; Girolami and Calderhead, J. Royal Statistical Society B 73, 2011), by lengths
// drawn from a wide range, so that nothing needs tuning.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace decid::frf {

struct SmcSettings {
  std::uint64_t seed = 1;
  int population = 256;
  int stage_moves = 8;  ///< of each walker at every power; it rises so far that half of the population still counts
  int settling_transitions = 40;  ///< at the last
  int chains = 16;                ///< that go on
  int thinning = 20;              ///< moves a draw
  int min_draws = 80;             ///< of each chain; as many again and again while they are not enough
  int max_draws = 1280;
  double max_rhat = 1.01;         ///< enough: every coordinate's R-hat is at most this
  double effective_draws = 1000;  ///< and it has so many
};

/// The likelihood around a point.
struct Local {
  /// Minus its logarithm; infinite where the point is impossible, and nothing else counts there.
  double misfit = 0.0;
  std::vector<double> gradient;     ///< of the misfit
  std::vector<double> information;  ///< about the coordinates; lower triangle, row after row
};
/// Sets all of `local`. Gradient and information need not be exact: they say where to jump, not what is drawn. Called
/// from any thread.
using Evaluate = std::function<void(std::span<const double> x, Local& local)>;

struct SmcResult {
  std::vector<std::vector<double>> chains;  ///< each: draw by draw, `size` coordinates
  std::vector<double> rhat, effective;      ///< of each coordinate
  double acceptance = 0.0;                  ///< share of the chains' jumps
  int stages = 0;                           ///< powers of the likelihood
  long long evaluations = 0;
};

/// Draws from exp(-misfit) times the prior of `size` coordinates: uniform from 0 to 1 of the first `uniform`, standard
/// normal of the others. Depends on the settings alone, not on
/// the threads. Throws Error for settings that are too small, and if 1000 draws in a row from the prior are impossible.
SmcResult walk(std::size_t size, std::size_t uniform, const Evaluate& evaluate, const SmcSettings& settings);

}  // namespace decid::frf
