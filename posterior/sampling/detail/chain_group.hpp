// `lanes` chains that warm up and draw together, with one reparameterisation per trial and one metric. Not installed.
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
  /// number: of the group, of settings.groups. Settings and stopped must outlive it; no transition begins once stopped
  /// is set.
  ChainGroup(const Target& target, const Settings& settings, int number, const std::atomic<bool>& stopped);

  using Report = std::function<void(const char* stage, double done)>;
  /// Warms up: see posterior.hpp. done: fraction of the warm-up.
  void warm_up(const Report& report);
  /// Drops the draws, and adapts the steps. last: nothing will be learned from the round.
  void begin_round(bool last);
  void draw(int count);
  /// Uses the trial draws as another window of the warm-up.
  void learn_from_round();

  /// Returns the draws of a trial's unknowns.
  const std::vector<State>& states(std::size_t trial, std::size_t chain) const { return trials_[trial].states[chain]; }
  const std::vector<Transition>& transitions(std::size_t chain) const { return transitions_[chain]; }
  int draws() const noexcept { return static_cast<int>(transitions_.front().size()); }
  /// Returns the draws apart() - 1, 2 apart() - 1, ... of a chain, with all coordinates of a trial.
  const std::vector<std::vector<double>>& points(std::size_t trial, std::size_t chain) const {
    return trials_[trial].points[chain];
  }
  int apart() const noexcept { return apart_; }
  double acceptance() const noexcept { return acceptance_; }
  int divergences() const noexcept { return divergences_; }
  int restarts() const noexcept { return restarts_; }
  long long leapfrog_steps() const noexcept { return sampler_.leapfrog_steps() * lanes; }

 private:
  struct Trial {
    ReparameterisationFit fit;                        // of the current window
    double annealed_deg = 0.0;                        // the fixed measurement noise
    std::vector<std::vector<double>> informations{};  // at the window's places
    std::array<std::vector<State>, lanes> states{};   // of the current round
    std::array<std::vector<std::vector<double>>, lanes> points{};
  };
  using Place = std::vector<AlignedVector<double>>;  // coordinates of each trial

  const Target& target() const noexcept { return sampler_.target(); }
  const Density& density(std::size_t trial) const { return target().density(trial); }
  double noise_deg(std::size_t trial) const;
  Sampler::Lanes unexplained_deg(std::size_t trial) const;
  double first_noise_deg(std::size_t trial) const;
  void place();
  void anneal(const Report& report);
  void metric_from_here();
  void adapt(int moves, int leapfrog_steps);
  void learn_in_window(int leapfrog_steps, bool last);
  void hold_slow_noise();
  void begin_window();
  void learn(int move, int moves);
  void end_window();
  void reparameterise();
  Sampler::Lanes log_mass();
  void restart(const Sampler::Lanes& badness, double limit);
  void release_noise();
  void keep();
  Place here() const;

  const Settings& settings_;
  const std::uint64_t number_;
  const std::atomic<bool>& stopped_;
  Sampler sampler_;
  std::vector<Trial> trials_;
  int leapfrog_steps_ = 0;  // per transition
  int windows_ = 0;         // and annealings
  int restarts_ = 0;
  std::vector<double> information_;  // of a trial, while a metric is made: megabytes that the system would clear again

  // The current window:
  std::vector<std::vector<double>> globals_;
  std::vector<Place> places_;  // where the information is needed

  // The current round:
  std::array<std::vector<Transition>, lanes> transitions_;
  bool last_round_ = false;
  int apart_ = 1, divergences_ = 0;
  double acceptance_ = 0.0;
};

}  // namespace decid::posterior
