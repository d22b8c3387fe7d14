// Cross-validation over frequencies: see comparison.hpp.
#include "posterior/frf/comparison.hpp"

#include <algorithm>

#include "base/math/math.hpp"
#include "posterior/sampling/leave_one_out.hpp"

namespace decid::frf {
namespace {

constexpr int max_used = 4000;  // draws

/// Returns the logarithms of the rows' densities, one draw after the other.
std::vector<double> log_densities(const Density& density, const Fit& found) {
  const int step = (found.draws() + max_used - 1) / max_used;
  std::vector<double> all, here(density.table().rows.size());
  for (int draw = 0; draw < found.draws(); draw += step) {
    density.log_densities(found.state(draw), here);
    all.insert(all.end(), here.begin(), here.end());
  }
  return all;
}

/// Returns log p(row | all other rows) from a fit to the other rows.
double refitted(const Density& density, std::size_t row, const SmcSettings& settings) {
  Table others = density.table();
  others.rows.erase(others.rows.begin() + static_cast<std::ptrdiff_t>(row));
  const Density without(density.model().protocol(), std::move(others), density.priors());
  const std::vector<double> values = log_densities(density, fit(without, settings));
  const std::size_t rows = density.table().rows.size(), draws = values.size() / rows;
  double largest = values[row], sum = 0.0;
  for (std::size_t draw = 0; draw < draws; ++draw) largest = std::max(largest, values[draw * rows + row]);
  for (std::size_t draw = 0; draw < draws; ++draw) sum += decid::exp(values[draw * rows + row] - largest);
  return largest + decid::log(sum / static_cast<double>(draws));
}

}  // namespace

RowsLeftOut leave_rows_out(const Density& density, const Fit& found, const SmcSettings& settings) {
  const posterior::LeaveOneOut left_out =
      posterior::leave_one_out(log_densities(density, found), static_cast<int>(density.table().rows.size()));
  RowsLeftOut made{left_out.pointwise, 0};
  for (std::size_t row = 0; row < made.pointwise.size(); ++row) {
    if (left_out.shapes[row] <= left_out.max_reliable_shape) continue;
    made.pointwise[row] = refitted(density, row, settings);
    ++made.refitted;
  }
  return made;
}

}  // namespace decid::frf
