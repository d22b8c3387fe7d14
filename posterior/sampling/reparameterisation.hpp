// Coordinates in which the posterior is nearly Gaussian. What the vestibular noise must be to explain the recording,
// and how well that is known, changes with the parameters: the posterior is a thin curved sheet of varying thickness,
// and no metric makes that round. Noise coefficient i is
//
//   w_i = m_i(v) + q_i(v)^4 u_i
//
// with m quadratic and q linear in the values v of the other unknowns. Chains leap in u and in the coordinates of v,
// where the density has the factor of the volume, the product of all q^4.
//
// Both are fitted at points that chains visit, from the information H = L L^t there: the most probable noise changes
// with the coordinates by -H_ww^-1 H_wv, and log L_ii is minus the logarithm of a coefficient's width.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/aligned.hpp"
#include "posterior/density/density.hpp"

namespace decid::posterior {

/// Values of chains side by side: value n of chain l at [n * lanes + l]. x: all coordinates of a Density; y: those of
/// the chart, with the same globals.
class Reparameterisation {
 public:
  using Lanes = std::array<double, lanes>;
  struct Workspace {
    AlignedVector<double> features, by_features, root, cube, by_root;
    std::vector<Lanes> z, slope;  // of each variable: its scaled value, and the derivative of that by its coordinate
  };

  /// y = x.
  Reparameterisation() = default;

  bool empty() const noexcept { return shift_by_feature_.empty(); }
  /// log_volume: of the product of all q^4, of each chain.
  void to_density(std::span<const double> y, std::span<double> x, Lanes& log_volume, Workspace& work, Isa isa) const;
  void from_density(std::span<const double> x, std::span<double> y, Workspace& work, Isa isa) const;
  /// From a gradient by x to that by y of the same minus log_volume, in place; after to_density(y).
  void pull_back(std::span<const double> y, std::span<double> gradient, Workspace& work, Isa isa) const;
  /// From the information about x to that about y, in place: a lower triangle of each chain.
  void change_information(std::span<const double> x, std::span<double> information, Workspace& work, Isa isa) const;

 private:
  friend class ReparameterisationFit;
  std::size_t variables() const noexcept { return variable_.size(); }
  std::size_t features() const noexcept { return 1 + variables() * (variables() + 3) / 2; }
  void scale(std::span<const double> x, Workspace& work) const;
  void widths(std::span<const double> x, Workspace& work, Isa isa) const;

  std::size_t noises_ = 0;
  std::vector<std::size_t> variable_;                             // numbers of the globals
  std::vector<double> middle_, scale_;                            // of each variable's share of its range
  std::vector<double> shift_by_feature_, shift_by_coefficient_;   // of m: a row a feature; a row a coefficient
  std::vector<double> width_by_variable_, width_by_coefficient_;  // of 4 (q - 1)
};

/// Collects points, and fits.
class ReparameterisationFit {
 public:
  explicit ReparameterisationFit(const Density& density);

  /// The points of `lanes` chains.
  void add(std::span<const double> x);
  /// And the information there, a lower triangle of each chain; it becomes its Cholesky factors.
  void add(std::span<const double> x, std::span<double> information);
  /// Forgets the points that were added before the last call of this one.
  void next_window();
  /// From the points that are left; an empty chart if they are too few, or lie on top of one another.
  Reparameterisation fit() const;

 private:
  struct Point {
    std::vector<double> variables, noise;
    std::vector<double> slopes;      // of each variable, a row; empty: none
    std::vector<double> log_widths;  // of each coefficient
  };
  struct LeastSquares;
  std::vector<const Point*> points() const;
  void scale(Reparameterisation& chart) const;
  LeastSquares shifts(const Reparameterisation& chart) const;
  LeastSquares log_widths(const Reparameterisation& chart) const;

  const Density& density_;
  std::vector<std::size_t> variable_;
  std::vector<Point> before_, points_;
};

}  // namespace decid::posterior
