// Networks whose every tensor differs from what it starts as, and images for them.
#pragma once

#include <string>
#include <vector>

#include "base/math/random.hpp"
#include "nn/network.hpp"

namespace decid::nn::testing {

/// A network with weights, BatchNorm parameters and statistics that are not what they start as.
inline Network<float> lived_in_network(Shape input, const std::string& architecture) {
  Network<float> network(input, architecture);
  network.initialise(9);
  std::uint64_t item = 100;
  for (Layer<float>& layer : network.layers()) {
    for (Parameter<float>& p : layer.parameters())
      for (std::size_t i = 0; p.fan_in == 0 && i < p.value.size(); ++i)
        p.value[i] += 0.3F * static_cast<float>(Random(1, Stream::weights, item).normal(i));
    for (RunningStatistics<float>& s : layer.statistics()) {
      ++item;
      for (std::size_t i = 0; i < s.value.size(); ++i)
        s.value[i] = static_cast<float>(Random(1, Stream::weights, item).uniform(i, 0.2, 1.5));
    }
    ++item;
  }
  return network;
}

inline std::vector<float> random_image(const Shape& shape, std::uint64_t item) {
  std::vector<float> image(static_cast<std::size_t>(shape.size()));
  for (std::size_t i = 0; i < image.size(); ++i)
    image[i] = static_cast<float>(Random(2, Stream::weights, item).normal(i));
  return image;
}

}  // namespace decid::nn::testing
