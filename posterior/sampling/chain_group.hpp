// `lanes` chains that warm up and draw together, with one reparameterisation and one metric. Not installed.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <span>
#include <vector>

#include "posterior/posterior.hpp"
#include "posterior/sampling/reparameterisation.hpp"
#include "posterior/sampling/sampler.hpp"

namespace decid::posterior {

class ChainGroup {
 public:
  /// number: of the group, of settings.groups. All arguments must outlive it; stopped: no transition begins once it is
  /// set.
  ChainGroup(const Density& density, const Observation& observation, const Settings& settings, int number,
             const std::atomic<bool>& stopped);

  using Report = std::function<void(const char* stage, double done)>;
  /// Warms up from any start: see posterior.hpp. done: fraction of the warm-up.
  void warm_up(std::span<const State> starts, const Report& report);
  /// Drops the draws, and adapts the steps. last: nothing will be learned from the round.
  void begin_round(bool last);
  void draw(int count);
  /// Uses the trial draws as another window of the warm-up.
  void learn_from_round();

  const std::vector<State>& states(int chain) const { return states_[static_cast<std::size_t>(chain)]; }
  const std::vector<Transition>& transitions(int chain) const { return transitions_[static_cast<std::size_t>(chain)]; }
  int draws() const noexcept { return static_cast<int>(states_.front().size()); }
  /// Returns the draws apart() - 1, 2 apart() - 1, ... of a chain, with all coordinates.
  const std::vector<std::vector<double>>& points(int chain) const { return points_[static_cast<std::size_t>(chain)]; }
  int apart() const noexcept { return apart_; }
  double acceptance() const noexcept { return acceptance_; }
  int divergences() const noexcept { return divergences_; }
  int restarts() const noexcept { return restarts_; }
  long long leapfrog_steps() const noexcept { return sampler_.leapfrog_steps() * lanes; }

 private:
  using Globals = std::array<double, Density::max_globals>;

  double noise_deg() const;
  Sampler::Lanes unexplained_deg() const;
  double first_noise_deg() const;
  void place(std::span<const State> starts);
  void anneal(const Report& report);
  void metric_from_here();
  void adapt(int moves, int leapfrog_steps);
  void learn_in_window(int leapfrog_steps, bool last);
  void hold_slow_noise();
  void begin_window();
  void learn(int move, int moves);
  void end_window();
  void add_log_mass(std::span<const double> x, std::span<const double> factors, Sampler::Lanes& log_mass);
  void restart(const Sampler::Lanes& badness, double limit);
  void release_noise();
  void keep();

  const Density& density_;
  const Observation& observation_;
  const Settings& settings_;
  const std::uint64_t number_;
  const std::atomic<bool>& stopped_;
  Sampler sampler_;
  int leapfrog_steps_ = 0;  // per transition
  int windows_ = 0;         // and annealings
  int restarts_ = 0;

  // The current window:
  ReparameterisationFit fit_;
  std::vector<Globals> globals_;
  std::vector<AlignedVector<double>> places_;  // where the information is needed

  // The current round:
  std::array<std::vector<State>, lanes> states_;
  std::array<std::vector<Transition>, lanes> transitions_;
  std::array<std::vector<std::vector<double>>, lanes> points_;
  bool last_round_ = false;
  int apart_ = 1, divergences_ = 0;
  double acceptance_ = 0.0;
};

}  // namespace decid::posterior
