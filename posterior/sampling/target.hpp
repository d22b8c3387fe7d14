// The trials that chains sample together: one, or several of one person with parameters in common.
//
// With several trials, each has its own vestibular noise, start, gain and measurement noise. Its information about all
// unknowns is an arrow: the trials' own unknowns depend on each other only through the common ones. Eliminating each
// trial's own first leaves a small matrix of the common unknowns, so time and memory grow with the number of trials.
// Rows of a trial's matrices are then: noise, start, gain and measurement noise, and the parameters last; of its
// metric: its own unknowns, then all common ones. With one trial, rows are the coordinates of its Density.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/aligned.hpp"
#include "posterior/density/density.hpp"

namespace decid::posterior {

/// A recorded trial. Density and observation must outlive the target.
struct TargetTrial {
  const Density* density;
  const Observation* observation;
  /// The number of the common unknown that each parameter is; empty for the only trial of a target.
  std::vector<std::size_t> common{};
};

class Target {
 public:
  using Lanes = std::array<double, lanes>;

  /// One trial.
  Target(const Density& density, const Observation& observation);
  /// Throws Error for no trial, and for several trials unless every parameter of each is a common unknown, no two
  /// parameters of a trial are the same, numbers begin at 0 without a gap, and priors of a common unknown are the same.
  explicit Target(std::vector<TargetTrial> trials);

  std::size_t trials() const noexcept { return trials_.size(); }
  const Density& density(std::size_t trial) const { return *trials_[trial].density; }
  const Observation& observation(std::size_t trial) const { return *trials_[trial].observation; }
  /// Returns the number of common unknowns; 0 for one trial.
  std::size_t commons() const noexcept { return uses_.size(); }
  bool joint() const noexcept { return commons() > 0; }
  /// Returns the number of a trial's own unknowns, and of the rows of its metric.
  std::size_t own(std::size_t trial) const;
  std::size_t rows(std::size_t trial) const { return own(trial) + commons(); }
  /// Returns the number of a trial's own globals, and of all globals of the target.
  std::size_t own_globals(std::size_t trial) const;
  std::size_t globals() const;

  /// Reorders a gradient by the coordinates of a trial's Density to rows of its metric, one value per chain each.
  void to_rows(std::size_t trial, std::span<const double> coordinates, std::span<double> rows) const;
  /// Reorders rows to coordinates.
  void from_rows(std::size_t trial, std::span<const double> rows, std::span<double> coordinates) const;
  /// Removes the prior of common unknowns that earlier trials count, at coordinates x.
  void count_once(std::size_t trial, std::span<const double> x, std::span<double> gradient, Lanes& potential) const;
  /// Moves the rows of parameters to the end of a symmetric matrix: a lower triangle, `width` values per element.
  void parameters_last(std::size_t trial, std::span<double> matrix, std::size_t width) const;

  /// Computes the inverse factors of the metric from each trial's information, in the order of parameters_last(). The
  /// last `held` own rows of each trial are fixed: they do not act on others. Returns false if a matrix is not positive
  /// definite. Several trials only.
  bool metric(std::span<const std::vector<double>> informations, std::size_t held,
              std::vector<std::vector<double>>& inverse_factors) const;
  /// Returns the sum of logarithms of the diagonal of the information's Cholesky factor, from each trial's factors.
  Lanes half_log_determinant(std::span<const std::vector<double>> factors) const;
  /// Appends the globals of each chain at these coordinates of all trials: own ones trial by trial, then common ones.
  void append_globals(std::span<const AlignedVector<double>> x, std::vector<std::vector<double>>& points) const;

 private:
  /// Adds a factor's corner times its transpose to the common unknowns' matrix; element(i, j): of the trial's factor.
  template <class Element>
  void add_corner(std::size_t trial, const Element& element, std::span<double> corner) const;

  std::vector<TargetTrial> trials_;
  std::vector<int> uses_;  // of each common unknown: the number of its trials
};

}  // namespace decid::posterior
