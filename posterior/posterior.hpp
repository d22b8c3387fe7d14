// The posterior of the controller behind a recording: draws of all unknowns.
//
//   const posterior::Density density(protocol, {});
//   const posterior::Posterior found = posterior::sample(density, density.observe(sway_rad), {});
//   if (found.agreed()) use(found.mean(sim::Kp), found.quantile(sim::Kp, 0.05), found.quantile(sim::Kp, 0.95));
//
// Chains begin at draws from the middle of the ranges. The assumed measurement noise starts high, where the recording
// has little influence, and falls in stages to the value of the power above 2 Hz (annealing). Several windows of points
// that the chains visit then define a reparameterisation that straightens the posterior (reparameterisation.hpp), and a
// metric; then the draws begin. If a parameter's R-hat is above 1.2 after some draws, these become another window, and
// a new round begins. The run ends when the chains agree and the draws suffice.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "posterior/density/density.hpp"
#include "posterior/sampling/diagnostics.hpp"
#include "posterior/sampling/target.hpp"

namespace decid::posterior {

/// For several trials, for controllers other than `dec`, whose gains are free, and for nine or more inferred
/// parameters, window_transitions count 5/3 times and max_leapfrog_steps four times.
struct Settings {
  std::uint64_t seed = 1;
  int groups = 1;                  ///< of 8 chains each (posterior::lanes), on their own threads
  int annealing_transitions = 45;  ///< transitions at each level of the measurement noise
  int window_transitions = 18;     ///< in each window of the warm-up
  int max_leapfrog_steps = 200;    ///< per transition at most; the widest direction sets the number
  int block = 20;                  ///< transitions of each chain between checks of sufficiency
  int rounds = 3;                  ///< at most
  int trial_draws = 25;            ///< of a chain, after which a round except the last may be repeated
  int min_draws = 40;              ///< of a chain
  int max_draws = 160;
  /// Leapfrog steps of a group after which no draws beyond min_draws begin; twice as many for several trials. After
  /// half of them no round is repeated.
  long long max_steps = 100'000;
  double max_rhat = agreed_rhat;  ///< sufficient: every quantity's R-hat is at most this
  double effective_draws = 100;   ///< sufficient: every quantity has this many
};

/// The progress of a run. stage: "annealing", "warming up", "drawing"; rhat: the largest, 0 before the first draws.
struct Progress {
  const char* stage;
  double done;  ///< fraction of the whole, 0 to 1; it may end early
  double rhat;
};
/// Returns false to stop: the run then returns the draws so far. One thread at a time calls it.
using OnProgress = std::function<bool(const Progress& progress)>;

/// The transition that led to a draw.
struct Transition {
  double log_density = 0.0;  ///< of the draw's coordinates, up to a constant (Stan's lp__)
  double energy = 0.0;       ///< at the transition's start, momentum included
  double acceptance = 0.0;   ///< probability
  double diverged = 0.0;     ///< 1 or 0
  template <class Archive>
  void archive(Archive& a) {
    a(log_density, energy, acceptance, diverged);
  }
};

/// Draws from the posterior. Quantities are Density's: the parameters by their index, Density::sensor_noise in degrees,
/// start, gain and the slow noise.
class Posterior {
 public:
  int chains() const noexcept { return chains_; }
  int draws() const noexcept { return static_cast<int>(states_.size()); }
  int draws_per_chain() const noexcept { return chains_ > 0 ? draws() / chains_ : 0; }
  /// Returns the states, chain by chain.
  std::span<const State> states() const noexcept { return states_; }

  /// Returns the transitions of the states.
  std::span<const Transition> transitions() const noexcept { return transitions_; }

  /// The maximum number of draws that are stored completely, with their vestibular noise, or one per chain: every k-th
  /// of each chain, k a power of two.
  static constexpr int max_points = 256;
  int points() const noexcept { return static_cast<int>(points_.size()); }
  /// Returns the coordinates of point i, one value per coordinate of the density; chain by chain.
  std::span<const double> point(int i) const { return points_.at(static_cast<std::size_t>(i)).coordinates; }
  /// Frees the points.
  void drop_points() { points_ = {}; }
  /// Returns the index of point i in states().
  int draw_of_point(int i) const { return points_.at(static_cast<std::size_t>(i)).draw; }

  /// Returns the number of the controller's parameters; 0 without draws.
  std::size_t parameters() const noexcept { return states_.empty() ? 0 : states_.front().parameters.size(); }
  /// Returns the place of a quantity in rhat() and effective_draws(), and the quantity of a place.
  std::size_t place(int quantity) const noexcept {
    return quantity < Density::sensor_noise ? static_cast<std::size_t>(quantity)
                                            : parameters() + static_cast<std::size_t>(quantity - Density::sensor_noise);
  }
  int quantity(std::size_t place) const noexcept {
    return static_cast<int>(place < parameters() ? place : place - parameters() + Density::sensor_noise);
  }
  /// Returns a quantity of a draw: a parameter in SI units, noise in degrees, the start in s, the gain without unit.
  static double value(const State& state, int quantity);
  /// Returns the quantity of all draws, chain by chain.
  std::vector<double> draws_for(int quantity) const;
  /// Returns the draws of each chain.
  std::vector<std::vector<double>> chains_for(int quantity) const;

  // Statistics of all draws, in the unit of the quantity.
  double mean(int quantity) const;
  double stddev(int quantity) const;
  double quantile(int quantity, double probability) const;
  /// Returns the correlation of two quantities; 0 if one of them is known.
  double correlation(int a, int b) const;

  // Diagnostics, see diagnostics.hpp, of the parameters in their order, then of measurement noise, start and gain.
  // Known quantities have an R-hat of 1.
  const std::vector<double>& rhat() const noexcept { return rhat_; }
  const std::vector<double>& effective_draws() const noexcept { return effective_; }
  /// Returns the effective draws of the 5% or 95% quantile, the smaller; NaN for fewer than four draws per chain.
  double tail_effective_draws(int quantity) const;
  /// Returns the Monte Carlo standard error of mean(): stddev() over the root of the mean's effective draws.
  double monte_carlo_error(int quantity) const;
  /// Returns the least energy fraction of the chains (diagnostics.hpp).
  double energy_fraction() const noexcept { return energy_fraction_; }
  int divergences() const noexcept { return divergences_; }
  int restarts() const noexcept { return restarts_; }                    ///< of chains that were stuck in a window
  long long leapfrog_steps() const noexcept { return leapfrog_steps_; }  ///< of all chains
  /// Returns the mean acceptance probability of the draws' transitions.
  double acceptance() const noexcept { return acceptance_; }
  /// Returns true if every R-hat is at most 1.05 and each quantity has 100 effective draws: the rule by which drawing
  /// stops (Settings). It counts neither restarts() nor tail_effective_draws().
  bool agreed() const;
  /// Returns the largest R-hat of a parameter; infinite without draws. Noise, start and gain may mix more slowly.
  double max_rhat() const;
  /// Returns true if max_rhat() is above 1.5. Below it, the draws of all chains together contain the chains'
  /// differences.
  bool chains_disagree() const;

  template <class Archive>
  void archive(Archive& a) {
    a(chains_, divergences_, restarts_, leapfrog_steps_, energy_fraction_, acceptance_, states_, transitions_, points_,
      rhat_, effective_);
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
  std::vector<Transition> transitions_;
  std::vector<Point> points_;
  std::vector<double> rhat_, effective_;
};

/// Draws from the posterior. The result depends only on the settings, not on threads or instruction set. Throws Error
/// for settings below 1, six window_transitions or trial_draws, or four max_draws.
Posterior sample(const Density& density, const Observation& observation, const Settings& settings,
                 const OnProgress& progress = {});

/// Draws from the joint posterior of several trials (target.hpp). Returns a Posterior for each trial's unknowns. Draw i
/// of each is the same joint draw, so common unknowns have the same values in all. Throws Error as sample() does.
std::vector<Posterior> sample_joint(const Target& target, const Settings& settings, const OnProgress& progress = {});

}  // namespace decid::posterior
