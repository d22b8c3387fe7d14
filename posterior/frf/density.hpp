// The posterior density of all unknowns of a published frequency response: the parameters of the protocol's body model,
// the scale of the sway, and the table's error beyond its confidence.
//
// Row i of the table is gain * H_i plus Gaussian errors of its real and its imaginary part, of variance
//   sd_i^2 + (error * gain * |H_i|)^2.
// sd_i comes from the table. `error` is unknown: without confidence it is the whole error, else the part that neither
// the model's controllers nor the table's confidence explain. The parameters' priors are uniform in their ranges or
// normal, where the loop is stable.
//
// Coordinates, in this order: the parameters with a uniform prior and the gain, as probabilities of their priors, from
// 0 to 1; the parameters with a normal prior and the error's logarithm, which are standard normal under their priors.
// Nv and theta are as in DeadBandPrior if both priors are uniform, with the passing gain instead of Nv.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "posterior/frf/dead_band_prior.hpp"
#include "posterior/frf/response.hpp"
#include "posterior/frf/smc.hpp"

namespace decid::frf {

/// Priors in addition to the parameters' ranges. Parameters that have a convention (sim::ParameterInfo) are fixed
/// unless the priors name them.
struct Priors {
  double gain = 0.1;  ///< the table's gains over the true ones are 1 +- this, uniform; at most 0.9; 0: known
  std::optional<double>
      error{};  ///< median of a log-normal distribution; 0: none. Empty: 0.01 with a confidence, else 0.05
  double error_factor = 3.0;  ///< two thirds of the distribution lie within this factor of the median
  std::vector<posterior::ParameterPrior> parameters = {};
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
  /// Throws Error as ResponseModel does, for priors out of their bounds, and for an error of 0 without confidence.
  Density(const sim::Protocol& protocol, Table table, const Priors& priors);

  const ResponseModel& model() const noexcept { return model_; }
  const Table& table() const noexcept { return table_; }
  /// Returns the priors with the error's median filled in.
  const Priors& priors() const noexcept { return priors_; }
  /// Returns the parameters with the priors' ranges, for the protocol's body.
  const sim::ParameterTable& ranges() const noexcept { return ranges_; }

  // Quantities are the parameters in their order, then gain and error.
  int gain() const noexcept { return static_cast<int>(ranges_.size()); }
  int error() const noexcept { return gain() + 1; }
  int quantities() const noexcept { return gain() + 2; }
  bool is_fixed(std::size_t parameter) const { return !place_of_[parameter]; }
  /// Returns true if a parameter has another prior than the protocol's range or its convention.
  bool has_given_priors() const;

  std::size_t size() const noexcept { return free_.size() + 2; }
  /// Returns the number of leading coordinates that are uniform from 0 to 1 under the prior.
  std::size_t uniform() const noexcept { return of_gain_ + 1; }
  /// Returns the coordinate of a quantity; of Nv and theta with uniform priors: of the passing gain's rank, and of the
  /// other one. Empty for a fixed parameter.
  std::optional<std::size_t> find_coordinate(int quantity) const;

  State state(std::span<const double> x) const;
  double value(const State& state, int quantity) const;
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
  /// Computes the logarithm of the density of each row's response, nats; one value per row.
  void log_densities(const State& state, std::span<double> values) const;
  /// Computes the responses at `here`, the state at x, and their derivatives by each coordinate, size() per row.
  void respond(std::span<const double> x, const State& here, std::span<sim::Complex> responses,
               std::span<sim::Complex> derived) const;

 private:
  /// Appends the factors of ResponseModel's derivatives that make the derivative by a parameter's coordinate.
  struct Factor {
    std::size_t coordinate, derivative;
    double factor;
  };
  void add_factors(std::size_t parameter, std::span<const double> x, const State& here,
                   std::vector<Factor>& factors) const;
  void add_parameters(bool normal);

  Table table_;
  Priors priors_;
  sim::ParameterTable ranges_;
  std::vector<posterior::Quantile> quantiles_;        // of the parameters
  std::vector<std::size_t> free_;                     // the parameters that have coordinates, in their order
  std::vector<std::optional<std::size_t>> place_of_;  // the coordinates of the parameters
  std::size_t of_gain_ = 0;                           // the coordinate
  ResponseModel model_;
  struct DeadBand {
    std::size_t nv, theta;  ///< the parameters
    DeadBandPrior prior;
  };
  std::optional<DeadBand> dead_band_;
};

}  // namespace decid::frf
