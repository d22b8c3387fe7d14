// Hamiltonian Monte Carlo on a Density: `lanes` chains in parallel with one shared metric. Each chain has its own step,
// because a chain that is still travelling needs smaller steps. Neal, Handbook of Markov Chain Monte Carlo, 2011,
// chapter 5.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/math/random.hpp"
#include "posterior/density/density.hpp"
#include "posterior/sampling/reparameterisation.hpp"

namespace decid::posterior {

class Sampler {
 public:
  using Lanes = std::array<double, lanes>;

  /// Starts the chains at 0 until coordinates() are set. group: chains of other groups have other random numbers.
  /// Density and observation must outlive it.
  Sampler(const Density& density, const Observation& observation, std::uint64_t seed, std::uint64_t group);

  /// Returns density.size() values per chain.
  std::span<double> coordinates() noexcept { return x_; }
  std::span<const double> coordinates() const noexcept { return x_; }
  const Random& random() const noexcept { return random_; }
  /// Fixes the measurement noise, for annealing; empty: its coordinate moves like the others.
  void fix_noise(std::optional<double> noise_deg) noexcept { fixed_noise_deg_ = noise_deg; }

  /// Returns minus the logarithm of the density at these points.
  Lanes potential(std::span<const double> x);
  /// See Density::information.
  void information(std::span<const double> x, std::span<double> matrices);
  /// Sets the coordinates of later transitions and of the metric.
  void set_reparameterisation(Reparameterisation reparameterisation) {
    reparameterisation_ = std::move(reparameterisation);
  }
  /// Fixes or releases the last globals (Density::held); the next set_metric() accounts for it.
  void hold_last(bool holds) noexcept { holds_ = holds; }
  /// Sets the metric: the inverse of a covariance. Returns false without a change if it is not positive definite.
  bool set_metric(std::span<const double> information);
  /// Returns the standard deviation of the globals in the widest direction, in units of the metric, from points of
  /// Density::globals() values each.
  double widest(std::span<const std::array<double, Density::max_globals>> points) const;

  /// Makes one transition of each chain: `leapfrog_steps` steps whose length is within a fifth of the chain's own, then
  /// accepts or rejects.
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
  void evaluate();
  /// Sets the values of fixed globals to 0.
  void clear_held(std::span<double> values) const;

  const Density& density_;
  const Observation& observation_;
  Density::Workspace work_;
  Random random_;
  std::uint64_t drawn_ = 0;  // number of random numbers used
  std::size_t size_;
  std::optional<double> fixed_noise_deg_;
  AlignedVector<double> x_, start_, y_, momentum_, gradient_, force_, direction_;
  Reparameterisation reparameterisation_;
  Reparameterisation::Workspace reparameterisation_work_;
  std::vector<double> metric_;  // the inverse of its Cholesky factor
  Lanes potential_{}, log_volume_{}, log_density_{}, energy_{}, acceptance_{}, step_{}, mean_log_step_{}, missing_{};
  std::array<bool, lanes> diverged_{};
  bool holds_ = false;
  double centre_ = 0.0;
  int adapted_ = 0;
  long long leapfrog_steps_ = 0;
};

}  // namespace decid::posterior
