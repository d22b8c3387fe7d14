// What a recording says about the controller behind it: draws from the posterior of all that is unknown.
//
//   const posterior::Density density(protocol, {});
//   const posterior::Posterior found = posterior::sample(density, density.observe(sway_rad), {});
//   if (found.agreed()) use(found.mean(sim::Kp), found.quantile(sim::Kp, 0.05), found.quantile(sim::Kp, 0.95));
//
// Chains begin anywhere: the sensor's noise starts high, where the recording says little, and is lowered in stages to
// what its second differences show (annealing). Then a chart that straightens the posterior (chart.hpp) and a metric
// are made from points that the chains visit, in several windows, and the draws begin. If the chains are far apart
// after some of them, these draws become one more window, and another round begins. It ends when the chains agree and
// the draws are enough.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "posterior/density/density.hpp"

namespace decid::posterior {

struct Settings {
  std::uint64_t seed = 1;
  int groups = 1;                  ///< of `lanes` chains each, which run on threads of their own
  int annealing_transitions = 15;  ///< transitions at each level of the sensor's noise
  int window_transitions = 18;     ///< in each window of warming up
  int max_leapfrog_steps = 200;    ///< of a transition: as many as the widest direction needs, to that many
  int block = 20;                  ///< transitions of each chain after which it is asked whether they are enough
  int rounds = 3;                  ///< at most
  int trial_draws = 25;            ///< of a chain, after which a round that is not the last may begin anew
  int min_draws = 40;              ///< of a chain
  int max_draws = 160;
  long long max_steps = 25'000;  ///< leapfrog steps of a group; beyond them no more draws are begun
  double max_rhat = 1.05;        ///< enough: every quantity's R-hat is at most this
  double effective_draws = 100;  ///< and it has so many
};

/// Where a run stands. stage: "annealing", "warming up", "drawing"; rhat: the largest, 0 before there are draws.
struct Progress {
  const char* stage;
  double done;  ///< of the whole, 0 to 1; it may end early
  double rhat;
};
/// Returns false to stop: what was drawn until then is returned. Called by one thread at a time.
using OnProgress = std::function<bool(const Progress& progress)>;

/// Quantities are Density's globals: the parameters in their order, then the sensor's noise in degrees, start and gain.
class Posterior {
 public:
  int chains() const noexcept { return chains_; }
  int draws() const noexcept { return static_cast<int>(states_.size()); }
  int draws_per_chain() const noexcept { return chains_ > 0 ? draws() / chains_ : 0; }
  /// Chain by chain.
  std::span<const State> states() const noexcept { return states_; }

  /// Some of the draws are kept whole, with their vestibular noise: every k-th of each chain, k a power of two, so that
  /// they are at most this many, or one a chain.
  static constexpr int max_points = 256;
  int points() const noexcept { return static_cast<int>(points_.size()); }
  /// The coordinates of point i, a value a coordinate of the density; chain by chain.
  std::span<const double> point(int i) const { return points_.at(static_cast<std::size_t>(i)).coordinates; }
  /// Frees these.
  void drop_points() { points_ = {}; }
  /// Which of states() it is.
  int draw_of_point(int i) const { return points_.at(static_cast<std::size_t>(i)).draw; }

  static double value(const State& state, int quantity);
  std::vector<double> draws_of(int quantity) const;

  double mean(int quantity) const;
  double deviation(int quantity) const;
  double quantile(int quantity, double share) const;
  /// Correlation of two quantities; 0 if one of them is known.
  double correlation(int a, int b) const;

  // Diagnostics, see diagnostics.hpp. Quantities that are known have an R-hat of 1.
  const std::vector<double>& rhat() const noexcept { return rhat_; }
  const std::vector<double>& effective_draws() const noexcept { return effective_; }
  double energy_fraction() const noexcept { return energy_fraction_; }
  int divergences() const noexcept { return divergences_; }
  int restarts() const noexcept { return restarts_; }                    ///< of chains that were stuck in a window
  long long leapfrog_steps() const noexcept { return leapfrog_steps_; }  ///< of all chains
  double acceptance() const noexcept { return acceptance_; }
  /// Returns true if every R-hat is at most 1.05 and each quantity has 100 effective draws.
  bool agreed() const;
  /// Returns true if an R-hat is above 1.2.
  bool apart() const;

  template <class Archive>
  void archive(Archive& a) {
    a(chains_, divergences_, restarts_, leapfrog_steps_, energy_fraction_, acceptance_, states_, points_, rhat_,
      effective_);
  }

 private:
  friend class Run;
  int chains_ = 0, divergences_ = 0, restarts_ = 0;
  long long leapfrog_steps_ = 0;
  double energy_fraction_ = 0.0, acceptance_ = 0.0;
  struct Point {
    int draw;
    std::vector<double> coordinates;
    template <class Archive>
    void archive(Archive& a) {
      a(draw, coordinates);
    }
  };
  std::vector<State> states_;
  std::vector<Point> points_;
  std::vector<double> rhat_, effective_;
};

/// starts: where the chains begin, one after the other and over again; empty: draws from the middle of the priors.
/// Depends on the settings alone, not on threads or instruction set. Throws Error if the recording is
/// constant, and for settings below 1, six window_transitions or
/// trial_draws, or four max_draws.
Posterior sample(const Density& density, const Observation& observation, const Settings& settings,
                 std::span<const State> starts = {}, const OnProgress& progress = {});

}  // namespace decid::posterior
