// What a published frequency response says about the controller behind it: draws from the posterior of all that is
// unknown, and whether the model explains the table.
//
//   const frf::Density density(protocol, frf::read_table("table.csv"), {});
//   const frf::Fit found = frf::fit(density, {});
//   use(found.mean(sim::Kp), found.quantile(sim::Kp, 0.05), found.told(sim::Kp), found.warnings());
#pragma once

#include <string>
#include <vector>

#include "base/warning.hpp"
#include "posterior/frf/density.hpp"
#include "posterior/frf/smc.hpp"

namespace decid::frf {

/// The response at a row that the draws mean.
struct Predicted {
  sim::Complex response;       ///< their mean
  double gain_low, gain_high;  ///< of 90 % of them
  double phase_deg, phase_low_deg, phase_high_deg;
  double distance;  ///< of the table's from their mean, in standard deviations of a part
};

/// How far the table is from the draws under its own confidence.
struct Misfit {
  double chi_square = 0.0;  ///< the draws' mean
  int degrees_of_freedom = 0;
  double p_value = 0.0;  ///< that a table of the draws is as far from them; NaN without confidence
};

/// Quantities are Density's: the parameters in their order, then gain and error.
class Fit {
 public:
  int chains() const noexcept { return chains_; }
  int draws() const noexcept { return static_cast<int>(draws_.front().size()); }
  int draws_per_chain() const noexcept { return draws() / chains_; }
  /// Of a quantity, chain by chain.
  const std::vector<double>& draws_of(int quantity) const { return draws_[static_cast<std::size_t>(quantity)]; }

  double mean(int quantity) const;
  double deviation(int quantity) const;
  double quantile(int quantity, double share) const;
  /// Of two quantities; 0 if one of them is known.
  double correlation(int a, int b) const;
  /// The standard deviation that was known beforehand, of stable loops.
  double prior_deviation(int quantity) const { return prior_deviations_[static_cast<std::size_t>(quantity)]; }
  /// How much of the prior's variance the table takes away: 1 all, 0 none.
  double told(int quantity) const;

  const std::vector<double>& rhat() const noexcept { return rhat_; }
  const std::vector<double>& effective_draws() const noexcept { return effective_; }
  double acceptance() const noexcept { return acceptance_; }
  long long evaluations() const noexcept { return evaluations_; }
  /// Returns true if every R-hat is at most 1.05 and each quantity has 100 effective draws.
  bool agreed() const;

  /// One a row.
  const std::vector<Predicted>& predicted() const noexcept { return predicted_; }
  const Misfit& misfit() const noexcept { return misfit_; }
  /// Returns true if a controller of the model explains the table; otherwise the parameters are no answer.
  bool explained() const;
  /// For people.
  const Warnings& warnings() const noexcept { return warnings_; }

 private:
  friend Fit fit(const Density& density, const SmcSettings& settings);
  void predict(const Density& density, const std::vector<State>& states);
  /// Root mean square of the relative error that the draws' mean response leaves.
  double left(const Density& density) const;
  void warn(const Density& density);

  int chains_ = 0;
  std::vector<std::vector<double>> draws_;  // by quantity
  std::vector<double> prior_deviations_, rhat_, effective_;
  double acceptance_ = 0.0;
  long long evaluations_ = 0;
  std::vector<Predicted> predicted_;
  Misfit misfit_;
  Warnings warnings_;
};

/// Throws Error for settings that walk() refuses, and where hardly any controller of the ranges is stable.
Fit fit(const Density& density, const SmcSettings& settings);

/// The probability that chi-square exceeds this; degrees_of_freedom: even, above 0.
double chi_square_beyond(double chi_square, int degrees_of_freedom);

}  // namespace decid::frf
