// Comparison of models by how well each predicts the observations that it has not seen (leave_one_out.hpp): differences
// with their standard errors, and stacking weights. Vehtari, Gelman, Gabry, Statistics and Computing 27, 2017; weights:
// Yao, Vehtari, Simpson, Gelman, Bayesian Analysis 13, 2018.
#pragma once

#include <span>
#include <vector>

namespace decid::posterior {

struct ComparedModel {
  double log_density = 0.0;     ///< sum over the observations, nats
  double difference = 0.0;      ///< of that sum from the best model's, 0 or below
  double standard_error = 0.0;  ///< of the difference, from the differences between observations
  double weight = 0.0;          ///< in the mixture of the models that predicts the observations best; the sum is 1
};

/// Compares models. pointwise: for each model the logarithms of the same observations' densities. Throws Error for no
/// model, fewer than 2 observations, different numbers of them, and values that are not finite.
std::vector<ComparedModel> compare_models(std::span<const std::vector<double>> pointwise);

}  // namespace decid::posterior
