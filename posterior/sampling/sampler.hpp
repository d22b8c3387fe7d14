// Hamiltonian Monte Carlo on a Target: `lanes` chains in parallel with one metric. Each chain has its own step, because
// a chain that is still travelling needs smaller steps. Neal, Handbook of Markov Chain Monte Carlo, 2011, chapter 5.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/math/random.hpp"
#include "posterior/sampling/reparameterisation.hpp"
#include "posterior/sampling/target.hpp"

namespace decid::posterior {

class Sampler {
 public:
  using Lanes = std::array<double, lanes>;

  /// Starts the chains at 0 until coordinates() are set. group: chains of other groups have other random numbers.
  Sampler(Target target, std::uint64_t seed, std::uint64_t group);

  const Target& target() const noexcept { return target_; }
  /// Returns the coordinates of a trial's Density, size() values per chain. Common unknowns are in each trial's.
  std::span<double> coordinates(std::size_t trial = 0) noexcept { return parts_[trial].x; }
  std::span<const double> coordinates(std::size_t trial = 0) const noexcept { return parts_[trial].x; }
  /// Fixes a trial's measurement noise, for annealing; empty: its coordinate moves like the others.
  void fix_noise(std::optional<double> noise_deg, std::size_t trial = 0) noexcept {
    parts_[trial].fixed_noise_deg = noise_deg;
  }

  /// Returns a trial's part of minus the logarithm of the density at these points of its Density.
  Lanes potential(std::span<const double> x, std::size_t trial = 0);
  /// See Density::information.
  void information(std::span<const double> x, std::span<double> matrices, std::size_t trial = 0);
  /// Sets the coordinates of later transitions and of the metric.
  void set_reparameterisation(Reparameterisation reparameterisation, std::size_t trial = 0) {
    parts_[trial].reparameterisation = std::move(reparameterisation);
  }
  /// Fixes or releases the last own globals of each trial (Density::held); the next set_metric() accounts for it.
  void hold_last(bool holds) noexcept { holds_ = holds; }
  /// Sets the metric, the inverse of a covariance, from each trial's information in the order of
  /// Target::parameters_last(). Returns false without a change if it is not positive definite.
  bool set_metric(std::span<const std::vector<double>> informations);
  /// Returns the standard deviation of the globals in the widest direction, in units of the metric, from points of
  /// Target::append_globals().
  double widest(std::span<const std::vector<double>> points) const;

  /// Makes one transition of each chain: draws the white noise given all else, then makes `leapfrog_steps` steps whose
  /// length is within a fifth of the chain's own, then accepts or rejects.
  void move(int leapfrog_steps);
  /// The last transition:
  const Lanes& acceptance() const noexcept { return acceptance_; }  ///< the acceptance probability
  const Lanes& energy() const noexcept { return energy_; }          ///< at its start, momentum included
  const std::array<bool, lanes>& diverged() const noexcept { return diverged_; }
  /// Logarithm of the density of its coordinates (Density::evaluate) after it, up to a constant.
  const Lanes& log_density() const noexcept { return log_density_; }
  long long leapfrog_steps() const noexcept { return leapfrog_steps_; }

  /// Starts dual averaging of the steps (Hoffman and Gelman, JMLR 15, 2014), from this step.
  void begin_adapting(double step);
  /// Adapts the steps after a transition, towards this acceptance.
  void adapt(double acceptance);
  /// Sets the steps to the means of the tried ones and stops adapting.
  void end_adapting();
  /// Returns the median of the chains' steps.
  double middle_step() const;

 private:
  struct Part {
    explicit Part(const Density& density, std::size_t rows);
    Density::Workspace work;
    std::optional<double> fixed_noise_deg;
    AlignedVector<double> x, start, y, gradient;            // by the coordinates of the Density
    AlignedVector<double> momentum, by_row, force, change;  // by the metric's rows
    AlignedVector<double> direction;                        // change by the coordinates
    Reparameterisation reparameterisation;
    Reparameterisation::Workspace reparameterisation_work;
    std::vector<double> metric;  // the inverse of its Cholesky factor
  };

  void evaluate();
  void add_forces();
  void draw_white_noise();
  void draw_momentum();
  void advance(Part& part, std::size_t trial, const Lanes& step);
  Lanes kinetic_energy() const;
  std::vector<double> metric_of_globals() const;
  std::size_t held_of(std::size_t trial) const { return target_.own(trial) - Density::held; }
  /// Sets the values of a trial's fixed rows to 0.
  void clear_held(std::size_t trial, std::span<double> values) const;

  Target target_;
  std::vector<Part> parts_;  // one per trial
  Isa isa_;
  Random random_;
  std::uint64_t drawn_ = 0;  // number of random numbers used
  Lanes potential_{}, log_volume_{}, log_density_{}, energy_{}, acceptance_{}, step_{}, mean_log_step_{}, missing_{};
  std::array<bool, lanes> diverged_{};
  bool holds_ = false;
  double centre_ = 0.0;
  int adapted_ = 0;
  long long leapfrog_steps_ = 0;
};

}  // namespace decid::posterior
