// Point estimate of a published frequency response, for comparison with its posterior: the least squares that
// posturography fits with.
//
// The least squares minimise sum w |log(H / T)|^2 over the rows, with the model's response H, the table's T, and the
// weight w = coherence / frequency (1 / frequency for tables without coherence): squared logarithms of the gains' ratio
// plus squared differences of the phases in rad. Near the table |log(H / T)| = |H - T| / |T|, so that the posterior's
// mode is the same if the table's sd is in proportion to |T| / sqrt(w), its gains and errors are exact, and the priors
// uniform.
#pragma once

#include "base/warning.hpp"
#include "posterior/frf/density.hpp"
#include "posterior/frf/optimum.hpp"

namespace decid::frf {

struct PointEstimate {
  State state;
  double misfit = 0.0;                  ///< half the weighted squares
  double passing_gain = 0.0;            ///< of the dead band; nv and theta act on the response only through it
  std::vector<sim::Complex> responses;  ///< of the model, one per row
  double left = 0.0;                    ///< root mean square of the relative error
  std::vector<bool> at_end;             ///< of the parameters: at an end of its range
  int agreeing = 0;                     ///< starts with the same misfit
  Warnings warnings = {};               ///< `no_controller`, by the rule of the posterior's
};

/// Returns the weights of the rows; their sum is the number of rows.
std::vector<double> log_ratio_weights(const Table& table);

/// Minimises the weighted squares of the log ratios in the ranges, where the loop is stable. The gain is 1, the error
/// 0; normal priors count as uniform.
PointEstimate fit_log_ratio(const Density& density, const OptimumSettings& settings);

}  // namespace decid::frf
