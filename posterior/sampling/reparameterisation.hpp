// Coordinates in which the posterior is nearly Gaussian. The vestibular noise that explains the recording, and its
// uncertainty, change with the parameters. The posterior is a thin curved sheet of varying thickness, which no metric
// makes round. Noise coefficient i is
//
//   w_i = m_i(v) + q_i(v)^4 u_i
//
// with m quadratic and q linear in the values v of the other unknowns. Chains move in u and in the coordinates of v,
// where the density has the volume's factor, the product of all q^4.
//
// Both are fitted at points that chains visit, from the information H = L L^t there. The most probable noise changes
// with the coordinates by -H_ww^-1 H_wv, and log L_ii is minus the logarithm of a coefficient's width.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/aligned.hpp"
#include "posterior/density/density.hpp"

namespace decid::posterior {

/// The coordinate transform. Values of chains are interleaved: value n of chain l at [n * lanes + l]. x: all
/// coordinates of a Density; y: those of the reparameterisation, with the same globals.
class Reparameterisation {
 public:
  using Lanes = std::array<double, lanes>;
  struct Workspace {
    AlignedVector<double> features, by_features, root, cube, by_root;
    std::vector<Lanes> z, slope;  // per variable: its scaled value, and the derivative of that by its coordinate
  };

  /// The identity, y = x.
  Reparameterisation() = default;

  bool empty() const noexcept { return shift_by_feature_.empty(); }
  /// Converts y to x. log_volume: of the product of all q^4, of each chain.
  void to_density(std::span<const double> y, std::span<double> x, Lanes& log_volume, Workspace& work, Isa isa) const;
  void from_density(std::span<const double> x, std::span<double> y, Workspace& work, Isa isa) const;
  /// Converts a gradient by x to the gradient by y of the same function minus log_volume, in place; call it after
  /// to_density(y).
  void pull_back(std::span<const double> y, std::span<double> gradient, Workspace& work, Isa isa) const;
  /// Converts the information about x to that about y, in place: a lower triangle per chain.
  void change_information(std::span<const double> x, std::span<double> information, Workspace& work, Isa isa) const;

 private:
  friend class ReparameterisationFit;
  std::size_t variables() const noexcept { return variable_.size(); }
  std::size_t features() const noexcept { return 1 + variables() * (variables() + 3) / 2; }
  void scale(std::span<const double> x, Workspace& work) const;
  void widths(std::span<const double> x, Workspace& work, Isa isa) const;

  std::size_t noises_ = 0, globals_ = 0;
  std::vector<std::size_t> variable_;                             // indices of the globals
  std::vector<double> middle_, scale_;                            // of each variable's fraction of its range
  std::vector<double> shift_by_feature_, shift_by_coefficient_;   // of m: a row per feature; a row per coefficient
  std::vector<double> width_by_variable_, width_by_coefficient_;  // of 4 (q - 1)
};

/// Collects points and fits a reparameterisation.
class ReparameterisationFit {
 public:
  /// parameters_last: informations have the rows of parameters after those of other globals.
  explicit ReparameterisationFit(const Density& density, bool parameters_last = false);

  /// Adds the points of `lanes` chains.
  void add(std::span<const double> x);
  /// Adds points with the information there, a lower triangle per chain, which becomes its Cholesky factors.
  void add(std::span<const double> x, std::span<double> information);
  /// Drops the points that were added before the last call of this function.
  void next_window();
  /// Fits the remaining points; returns the identity if they are too few or coincide.
  Reparameterisation fit() const;

 private:
  struct Point {
    std::vector<double> variables, noise;
    std::vector<double> slopes;      // a row per variable; empty: none
    std::vector<double> log_widths;  // of each coefficient
  };
  struct LeastSquares;
  std::vector<const Point*> points() const;
  void scale(Reparameterisation& fit) const;
  LeastSquares shifts(const Reparameterisation& fit) const;
  LeastSquares log_widths(const Reparameterisation& fit) const;

  /// Returns the row of a global in an information.
  std::size_t row(std::size_t global) const;

  const Density& density_;
  const bool parameters_last_;
  std::vector<std::size_t> variable_;
  std::vector<Point> before_, points_;
};

}  // namespace decid::posterior
