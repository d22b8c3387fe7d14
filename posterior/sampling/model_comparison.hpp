// Compares models of one recording by their predictions of each observation from all others (leave_one_out.hpp).
// Stacking: Yao, Vehtari, Simpson, Gelman, Bayesian Analysis 13, 2018.
#pragma once

#include <span>
#include <vector>

namespace decid::posterior {

/// One model among others.
struct ComparedModel {
  double log_density = 0.0;     ///< sum of its log predictive densities, nats
  double difference = 0.0;      ///< to the model with the largest sum: 0 or below
  double standard_error = 0.0;  ///< of the difference, from the observations' differences; 0 for that model
  double weight = 0.0;  ///< stacking: the mixture of the models with these weights predicts best; they add up to 1

  template <class Archive>
  void archive(Archive& a) {
    a(log_density, difference, standard_error, weight);
  }
};

/// Compares models. pointwise: of each model its log predictive densities of the same observations. Throws Error for no
/// model, fewer than 2 observations, and different numbers of them.
std::vector<ComparedModel> compare_models(std::span<const std::vector<double>> pointwise);

}  // namespace decid::posterior
