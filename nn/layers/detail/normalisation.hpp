// BatchNorm's scale and shift of a channel, from its parameters and a mean and variance: the batch's in training, the
// running ones in inference. Not installed.
#pragma once

#include <cmath>

#include "nn/layers/layer.hpp"

namespace decid::nn {

/// y = gamma (x - mean) / sqrt(variance + epsilon) + beta = scale x + shift.
struct Normalisation {
  double inverse_stddev, scale, shift;
};

inline Normalisation normalisation(double gamma, double beta, double mean, double variance) {
  const double inverse = 1 / std::sqrt(variance + BatchNorm::epsilon), scale = gamma * inverse;
  return {inverse, scale, beta - mean * scale};
}

}  // namespace decid::nn
