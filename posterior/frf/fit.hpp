// The posterior of the controller behind a published frequency response: draws of all unknowns, and a check whether the
// model explains the table.
//
//   const frf::Density density(protocol, frf::read_table("table.csv"), {});
//   const frf::Fit found = frf::fit(density, {});
//   use(found.mean(sim::Kp), found.quantile(sim::Kp, 0.05), found.contraction(sim::Kp), found.warnings());
#pragma once

#include <string>
#include <vector>

#include "base/warning.hpp"
#include "posterior/frf/density.hpp"
#include "posterior/frf/smc.hpp"

namespace decid::frf {

/// The posterior response at a row.
struct Predicted {
  sim::Complex response;       ///< mean of the draws
  double gain_low, gain_high;  ///< 90% interval
  double phase_deg, phase_low_deg, phase_high_deg;
  double distance;  ///< of the table's response from the mean, in standard deviations of one part
};

/// The distance of the table from the draws under its own confidence.
struct Misfit {
  double chi_square = 0.0;  ///< mean of the draws
  int degrees_of_freedom = 0;
  double p_value = 0.0;  ///< probability of a table at least as far from the draws; NaN without confidence
};

/// Draws from the posterior. Quantities are Density's: the parameters in their order, then gain and error.
class Fit {
 public:
  int gain() const noexcept { return error() - 1; }
  int error() const noexcept { return static_cast<int>(draws_.size()) - 1; }
  int chains() const noexcept { return chains_; }
  int draws() const noexcept { return static_cast<int>(draws_.front().size()); }
  int draws_per_chain() const noexcept { return draws() / chains_; }
  /// Returns the draws of a quantity, chain by chain.
  const std::vector<double>& draws_for(int quantity) const { return draws_[static_cast<std::size_t>(quantity)]; }
  /// Returns the draws of each chain.
  std::vector<std::vector<double>> chains_for(int quantity) const;

  double mean(int quantity) const;
  double stddev(int quantity) const;
  double quantile(int quantity, double probability) const;
  /// Returns the correlation of two quantities; 0 if one of them is known.
  double correlation(int a, int b) const;
  /// Returns the standard deviation under the prior, over stable loops.
  double prior_stddev(int quantity) const { return prior_stddevs_[static_cast<std::size_t>(quantity)]; }
  /// Returns the posterior contraction: the fraction of the prior's variance that the table removes, 0 to 1.
  double contraction(int quantity) const;

  /// Returns R-hat of each quantity, and its effective draws (posterior/sampling/diagnostics.hpp); 1 and all draws for
  /// fixed parameters.
  const std::vector<double>& rhat() const noexcept { return rhat_; }
  const std::vector<double>& effective_draws() const noexcept { return effective_; }
  double acceptance() const noexcept { return acceptance_; }
  long long evaluations() const noexcept { return evaluations_; }
  /// Returns true if every R-hat is at most 1.05 and each quantity has 100 effective draws.
  bool agreed() const;

  /// Returns one prediction per row.
  const std::vector<Predicted>& predicted() const noexcept { return predicted_; }
  const Misfit& misfit() const noexcept { return misfit_; }
  /// Returns true if a controller of the model explains the table; otherwise do not use the parameters.
  bool explained() const;
  /// Returns the root mean square of the relative error that the draws' mean response leaves.
  double left() const noexcept { return left_; }
  /// Returns the state of a draw.
  State state(int draw) const;
  /// Returns warnings for the user.
  const Warnings& warnings() const noexcept { return warnings_; }

 private:
  friend Fit fit(const Density& density, const SmcSettings& settings);
  void predict(const Density& density, const std::vector<State>& states);
  void warn(const Density& density);

  int chains_ = 0;
  std::vector<std::vector<double>> draws_;  // by quantity
  std::vector<double> prior_stddevs_, rhat_, effective_;
  double acceptance_ = 0.0, left_ = 0.0;
  long long evaluations_ = 0;
  std::vector<Predicted> predicted_;
  Misfit misfit_;
  Warnings warnings_;
};

/// Draws from the posterior. Throws Error for settings that sample_smc() refuses, and if hardly any controller in the
/// ranges is stable.
Fit fit(const Density& density, const SmcSettings& settings);

/// Returns `no_controller` if the response misses the table by more than 20% (`left`, the root mean square of the
/// relative error) and, if the table has a confidence, its p-value is below 1e-6; else nothing.
Warnings no_controller_warnings(const Density& density, double left, double p_value);

/// Returns the probability that chi-square exceeds this; degrees_of_freedom: even, above 0.
double chi_square_beyond(double chi_square, int degrees_of_freedom);

}  // namespace decid::frf
