// Models that together have every kind of layer, and what decid itself says of trials.
#pragma once

#include <algorithm>
#include <cmath>

#include "dataset/npz/npz.hpp"
#include "identify/training/presets.hpp"
#include "nn/predictor.hpp"
#include "tests/near.hpp"
#include "tests/tools/firmware/models.hpp"

namespace decid::test {

/// Every layer, stride, padding and pool, in planes and in columns, and both kinds of heads.
inline std::vector<Model> models_of_every_layer() {
  std::vector<Model> all;
  const dataset::ImageSettings plane{.window = 200, .half_spectrum = true, .standardize_rows = true, .rows = 40};
  all.push_back(made_up_model(sim::short_protocol(), plane,
                              "conv 4 3x3 pad 1x1; batchnorm; relu; maxpool 3x2 stride 2x2; conv 5 4x3 stride 2x1 pad "
                              "2x0; relu; avgpool 2x2; batchnorm; maxpool 2x2; globalavgpool; fc 7"));
  all.push_back(made_up_model(sim::short_protocol(), preset_named("short").image,
                              "avgpool 3x1 stride 2x1; conv 6 7x1 stride 2x1 pad 3x0; batchnorm; statspool; fc 9; "
                              "batchnorm; relu; conv 8 1x1; relu; fc 72",
                              mixture_head(2)));
  // As a training would begin: covariances near the identity.
  for (nn::Parameter<float>& parameter : all.back().network.layers().back().parameters())
    for (float& value : parameter.value) value *= all.back().head->first_weights();
  return all;
}

inline std::vector<float> images_of(const Model& model, const dataset::Dataset& data) {
  const auto values = static_cast<std::size_t>(model.images().shape().size());
  std::vector<float> images(values * data.parameters.size());
  for (int i = 0; i < data.trials(); ++i)
    model.make_input(data.trial(i), std::span(images).subspan(static_cast<std::size_t>(i) * values, values));
  return images;
}

inline std::vector<float> outputs_of_all(const Model& model, const dataset::Dataset& data) {
  return predict(model, data.trials(), 64, sways_in_memory([&](int i) { return data.trial(i); }));
}

/// Bounds the difference between two engines' outputs. In each layer each sum of products is rounded; errors are as
/// often up as down, so they grow with the root of their number, times the largest output.
inline double rounding_of(const Model& model, std::span<const float> outputs) {
  double sum = 0.0, largest = 0.0;
  for (const nn::Layer<float>& layer : model.network.layers()) {
    int terms = layer.src_shape().rows * layer.src_shape().columns;  // of a pool or statistics at most
    for (const nn::Parameter<float>& p : layer.parameters()) terms = std::max(terms, p.fan_in);
    sum += terms;
  }
  for (const float value : outputs) largest = std::max(largest, std::abs(static_cast<double>(value)));
  return 4.0 * 0x1p-24 * std::sqrt(sum) * largest;  // four deviations
}

}  // namespace decid::test
