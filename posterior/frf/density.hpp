// The posterior density of all unknowns of a published frequency response: the seven parameters, the scale of the sway,
// and the table's error beyond its confidence.
//
// Row i of the table is gain * H_i plus Gaussian errors of its real and its imaginary part, of variance
//   sd_i^2 + (error * gain * |H_i|)^2.
// sd_i comes from the table. `error` is unknown: without confidence it is the whole error, else the part that neither
// the model's controllers nor the table's confidence explain. The prior is uniform in the parameters' ranges where the
// loop is stable.
//
// Coordinates are uniform from 0 to 1 under the prior: parameters and gain in their ranges, Nv and theta as in
// DeadBandPrior, with the passing gain instead of Nv. The coordinate of the error's logarithm is normal.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "posterior/frf/dead_band_prior.hpp"
#include "posterior/frf/response.hpp"
#include "posterior/frf/smc.hpp"

namespace decid::frf {

/// Priors in addition to the parameters' ranges.
struct Priors {
  double gain = 0.1;  ///< the table's gains over the true ones are 1 +- this, uniform; at most 0.9; 0: known
  std::optional<double>
      error{};  ///< median of a log-normal distribution; 0: none. Empty: 0.01 with a confidence, else 0.05
  double error_factor = 3.0;  ///< two thirds of the distribution lie within this factor of the median
};

/// A point as physical quantities.
struct State {
  sim::Parameters parameters;
  double gain = 1.0;
  double error = 0.0;
};

/// The density. Immutable: all threads may share it.
class Density {
 public:
  /// The quantities after the parameters.
  enum Quantity { gain = 7, error = 8, quantities = 9 };

  /// Throws Error as ResponseModel does, for priors out of their bounds, and for an error of 0 without confidence.
  Density(const sim::Protocol& protocol, Table table, const Priors& priors);

  const ResponseModel& model() const noexcept { return model_; }
  const Table& table() const noexcept { return table_; }
  /// Returns the priors with the error's median filled in.
  const Priors& priors() const noexcept { return priors_; }
  static constexpr std::size_t size() { return quantities; }
  /// Returns the number of leading coordinates that are uniform from 0 to 1 under the prior.
  static constexpr std::size_t uniform() { return error; }

  State state(std::span<const double> x) const;
  static double value(const State& state, int quantity);
  bool is_stable(const State& state) const { return model_.is_stable(state.parameters); }
  /// Computes the table's responses without errors; responses: one per row.
  void respond(const State& state, std::span<sim::Complex> responses) const;
  /// Returns the variance of one part of a row's response.
  double variance(std::size_t row, sim::Complex response, double relative_error) const;
  /// Computes minus the logarithm of the likelihood, up to a constant; infinite where the loop is unstable. Gradient
  /// and information ignore the effect of Nv's rank.
  void evaluate(std::span<const double> x, Local& local) const;
  /// Returns chi-square: the sum over the rows of |table - response|^2 over the variance, two degrees of freedom per
  /// row.
  double chi_square(const State& state, double relative_error) const;

 private:
  /// Returns the derivatives by each coordinate of a response's variables: parameters, the passing gain for Nv, gain.
  std::array<double, quantities> by_coordinates(std::span<const double> x) const;

  Table table_;
  Priors priors_;
  sim::ParameterTable ranges_;  // for the protocol's body
  ResponseModel model_;
  DeadBandPrior dead_band_;
};

}  // namespace decid::frf
