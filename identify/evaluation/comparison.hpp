// Network, iterative fit and fit started at the network's answer, on the same trials with known parameters.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/parameters.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid {

/// One way to identify, over all trials. Errors are squared differences of z-scored parameters, as a model's MSE.
struct MethodFigures {
  std::string name, description;
  std::vector<double> mse_per_parameter;
  double mse = 0.0;
  double mse_standard_error = 0.0;  ///< of the mean over trials
  double simulations = 0.0;         ///< a trial, on average
  double seconds = 0.0;             ///< a trial, wall time
  /// Root mean square of error / standard error, over trials and parameters: 1 if standard errors are correct, above 1
  /// if they are too small. Only for the means of fits.
  std::optional<double> error_per_standard_error;
};

struct ComparisonFigures {
  std::string version;        ///< decid's
  std::string model, sha256;  ///< "built-in model"; of its weights
  std::string trials_from;    ///< "seed 7" or a data set's name
  sim::Protocol protocol;
  int trials = 0;
  int threads = 0;
  long long budget = 0;  ///< simulations allowed for a fit
  int starts = 0;
  std::vector<MethodFigures> methods;
};

/// Errors of estimates, each in the order of the trials. stddev: the divisor of z-scores.
MethodFigures compute_errors(std::string name, std::string description, std::span<const sim::Parameters> estimates,
                             std::span<const sim::Parameters> truth, const sim::Parameters& stddev);

}  // namespace decid
