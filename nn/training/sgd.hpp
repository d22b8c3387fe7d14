// Stochastic gradient descent with momentum and weight decay.
#pragma once

#include <span>
#include <vector>

#include "nn/layers/layer.hpp"

namespace decid::nn {

struct SgdSettings {
  double momentum = 0.9;
  double weight_decay = 1e-4;  ///< L2, on weights only
};

/// The optimiser's memory: a velocity for each value of each parameter, in the network's order of parameters.
template <class T>
using MomentumBuffers = std::vector<std::vector<T>>;

/// One step of one parameter: v = momentum v + (gradient + weight_decay w), w = w - learning_rate v. `gradient` and
/// `velocity` have as many values as the parameter.
template <class T>
void sgd_step(Parameter<T>& parameter, std::span<const T> gradient, std::span<T> velocity, double learning_rate,
              const SgdSettings& settings);

}  // namespace decid::nn
