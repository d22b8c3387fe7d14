// Hamiltonian Monte Carlo on a Density: `lanes` chains that leap side by side, with one metric for all and a step of
// their own each: one that is still on its way needs smaller ones. Neal, Handbook of Markov Chain Monte Carlo, 2011,
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

  /// The chains stand at 0 until coordinates() are set. group: chains of other groups have other random numbers.
  /// Density and observation must outlive it.
  Sampler(const Density& density, const Observation& observation, std::uint64_t seed, std::uint64_t group);

  /// density.size() values a chain.
  std::span<double> coordinates() noexcept { return x_; }
  std::span<const double> coordinates() const noexcept { return x_; }
  const Random& random() const noexcept { return random_; }
  /// For a start that is annealed: the sensor's noise is this; empty: it is a coordinate like the others.
  void fix_noise(std::optional<double> noise_deg) noexcept { fixed_noise_deg_ = noise_deg; }

  /// Minus the logarithm of the density at these points.
  Lanes potential(std::span<const double> x);
  /// See Density::information.
  void information(std::span<const double> x, std::span<double> matrices);
  /// Leaps are in its coordinates from here on, and the metric is of these.
  void set_chart(Reparameterisation chart) { chart_ = std::move(chart); }
  /// Holds the last globals where they are (Density::held), or lets them go; the next set_metric() counts with it.
  void hold_last(bool holds) noexcept { holds_ = holds; }
  /// The metric becomes this: the inverse of a covariance. False, and nothing changes, if it is not positive definite.
  bool set_metric(std::span<const double> information);
  /// Deviation of the globals in the widest direction, in units of the metric; from points of them, `globals` values
  /// each.
  double widest(std::span<const std::array<double, Density::globals>> points) const;

  /// One transition of each chain: `leaps` steps of leapfrog, of a length within a fifth of the chain's own, then
  /// accepted or not.
  void move(int leapfrog_steps);
  /// Of the last transition.
  const Lanes& acceptance() const noexcept { return acceptance_; }  ///< the probability with which it was accepted
  const Lanes& energy() const noexcept { return energy_; }          ///< at its start, momentum included
  const std::array<bool, lanes>& diverged() const noexcept { return diverged_; }
  long long leapfrog_steps() const noexcept { return leapfrog_steps_; }

  /// Steps from here on are found by dual averaging (Hoffman and Gelman, JMLR 15, 2014), beginning with this one.
  void begin_adapting(double step);
  /// After a transition: towards that acceptance.
  void adapt(double acceptance);
  /// Steps become the means of those tried, and stay.
  void end_adapting();
  /// The middle of the chains' steps.
  double middle_step() const;

 private:
  void evaluate();
  /// Sets what belongs to the globals that are held to 0.
  void clear_held(std::span<double> values) const;

  const Density& density_;
  const Observation& observation_;
  Density::Workspace work_;
  Random random_;
  std::uint64_t drawn_ = 0;  // random numbers used
  std::size_t size_;
  std::optional<double> fixed_noise_deg_;
  AlignedVector<double> x_, start_, y_, momentum_, gradient_, force_, direction_;
  Reparameterisation chart_;
  Reparameterisation::Workspace chart_work_;
  std::vector<double> metric_;  // the inverse of its Cholesky factor
  Lanes potential_{}, energy_{}, acceptance_{}, step_{}, mean_log_step_{}, missing_{};
  std::array<bool, lanes> diverged_{};
  bool holds_ = false;
  double centre_ = 0.0;
  int adapted_ = 0;
  long long leapfrog_steps_ = 0;
};

}  // namespace decid::posterior
