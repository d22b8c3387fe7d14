// Errors of a method: see comparison.hpp.
#include "identify/evaluation/comparison.hpp"

#include <algorithm>
#include <cmath>

namespace decid {

MethodFigures compute_errors(std::string name, std::string description, std::span<const sim::Parameters> estimates,
                             std::span<const sim::Parameters> truth, const sim::Parameters& stddev) {
  MethodFigures figures;
  figures.name = std::move(name);
  figures.description = std::move(description);
  const auto count = static_cast<double>(truth.size());
  figures.mse_per_parameter.resize(stddev.size());
  double squares = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    double of_trial = 0;
    for (std::size_t p = 0; p < stddev.size(); ++p) {
      const double error = (estimates[i][p] - truth[i][p]) / stddev[p];
      figures.mse_per_parameter[p] += error * error / count;
      of_trial += error * error / static_cast<double>(stddev.size());
    }
    figures.mse += of_trial / count;
    squares += of_trial * of_trial / count;
  }
  if (truth.size() > 1)
    figures.mse_standard_error = std::sqrt(std::max(0.0, squares - figures.mse * figures.mse) / (count - 1));
  return figures;
}

}  // namespace decid
