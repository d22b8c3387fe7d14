// The posterior density of everything unknown about a published frequency response: the seven parameters, how the sway
// is scaled, and by how much the table errs beyond its confidence.
//
// Row i of the table is gain * H_i plus Gaussian errors of its real and its imaginary part, of variance
//   sd_i^2 + (error * gain * |H_i|)^2,
// sd_i from the table, `error` unknown: all there is if the table has no confidence, else what no controller of the
// model explains and what the table's confidence forgets. The prior is uniform in the parameters' ranges where the loop
// is stable.
//
// Coordinates are uniform from 0 to 1 beforehand: parameters and gain in their ranges, Nv and theta as DeadBandPrior
// has them, what passes in Nv's place; and one that is normal, of the error's logarithm.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "posterior/frf/dead_band_prior.hpp"
#include "posterior/frf/response.hpp"
#include "posterior/frf/smc.hpp"

namespace decid::frf {

/// What is known beforehand besides the parameters' ranges.
struct Priors {
  double gain = 0.1;  ///< the table's gains over the true ones are 1 +-, uniform, to 0.9; 0: known
  std::optional<double>
      error{};  ///< median of a log-normal distribution; 0: none. Empty: 0.01 beside a confidence, else 0.05
  double error_factor = 3.0;  ///< two thirds of it lie within this factor of the median
};

/// A point in terms of what it means.
struct State {
  sim::Parameters parameters;
  double gain = 1.0;
  double error = 0.0;
};

/// Immutable: one serves all threads.
class Density {
 public:
  /// The quantities behind the parameters.
  enum Quantity { gain = 7, error = 8, quantities = 9 };

  /// Throws Error as ResponseModel does, for priors out of their bounds, and for an error of 0 without confidence.
  Density(const sim::Protocol& protocol, Table table, const Priors& priors);

  const ResponseModel& model() const noexcept { return model_; }
  const Table& table() const noexcept { return table_; }
  /// With the error's median filled in.
  const Priors& priors() const noexcept { return priors_; }
  static constexpr std::size_t size() { return quantities; }
  /// The first of them, uniform from 0 to 1 beforehand.
  static constexpr std::size_t uniform() { return error; }

  State state(std::span<const double> x) const;
  static double value(const State& state, int quantity);
  bool is_stable(const State& state) const { return model_.is_stable(state.parameters); }
  /// What the table would say without errors; responses: one a row.
  void respond(const State& state, std::span<sim::Complex> responses) const;
  /// Of a part of a row's response.
  double variance(std::size_t row, sim::Complex response, double relative_error) const;
  /// Minus the logarithm of the likelihood, up to a constant; infinite where the loop is not stable. Gradient and
  /// information leave out what Nv's rank does.
  void evaluate(std::span<const double> x, Local& local) const;
  /// The sum over the rows of |table - response|^2 over the variance: chi-square, two degrees of freedom a row.
  double chi_square(const State& state, double relative_error) const;

 private:
  /// How fast what a response is derived by changes with each coordinate: parameters, what passes in Nv's place, gain.
  std::array<double, quantities> by_coordinates(std::span<const double> x) const;

  Table table_;
  Priors priors_;
  sim::ParameterTable ranges_;  // for the protocol's body
  ResponseModel model_;
  DeadBandPrior dead_band_;
};

}  // namespace decid::frf
