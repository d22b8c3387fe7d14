// Which model predicts a published frequency response best? Cross-validation over the frequencies: the density of each
// row given all other rows, from the draws by importance sampling (posterior/sampling/leave_one_out.hpp). Few draws
// dominate the weights of a row that the others hardly predict: such a row is left out in a fit of its own.
#pragma once

#include "posterior/frf/fit.hpp"
#include "posterior/sampling/model_comparison.hpp"

namespace decid::frf {

struct RowsLeftOut {
  std::vector<double> pointwise;  ///< log p(row | all other rows), nats
  int refitted = 0;               ///< rows with fits of their own
};

/// Computes the cross-validation of a fit. Throws Error as fit() does.
RowsLeftOut leave_rows_out(const Density& density, const Fit& found, const SmcSettings& settings);

}  // namespace decid::frf
