// Tests of nn/layers/padded_pool.cpp against loops over windows.
#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "nn/fit.hpp"
#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

// The plain definition, value by value, of what the layer computes with vectors.
TEST_CASE("padded pools have the bits of loops over windows, NaN and zeros of both signs included") {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  const Shape in{2, 7, 6};
  constexpr int samples = 19, kernel = 3, stride = 2, pad = 1;
  auto inputs = hashed_values<float>(3, static_cast<std::size_t>(samples * in.size()), 3);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (i % 3 == 0) inputs[i] = std::trunc(inputs[i]);  // equal ones in a window, zeros of both signs
    if (i % 41 == 0) inputs[i] = i % 2 == 0 ? nan : -infinity;
  }
  for (const bool takes_max : {true, false}) {
    const Network<float> network(in, takes_max ? "maxpool 3 stride 2 pad 1" : "avgpool 3 stride 2 pad 1");
    const Shape out = network.output_shape();
    const auto by_output = hashed_values<float>(4, static_cast<std::size_t>(samples * out.size()));
    std::vector<float> outputs, gradient(inputs.size(), 0.0F);
    for (int plane = 0; plane < samples * in.channels; ++plane) {
      const float* const x = inputs.data() + plane * in.rows * in.columns;
      float* const dx = gradient.data() + plane * in.rows * in.columns;
      for (int i = 0; i < out.rows; ++i)
        for (int j = 0; j < out.columns; ++j) {
          const float dy = by_output[outputs.size()];
          int best = -1;
          float sum = 0;
          for (int row = i * stride - pad; row < i * stride - pad + kernel; ++row)
            for (int column = j * stride - pad; column < j * stride - pad + kernel; ++column) {
              const int place = row * in.columns + column;
              if (row < 0 || row >= in.rows || column < 0 || column >= in.columns) continue;
              if (best < 0 || x[place] > x[best] || std::isnan(x[place])) best = place;
              sum += x[place];
              if (!takes_max) dx[place] += dy * (1.0F / 9);
            }
          outputs.push_back(takes_max ? x[best] : sum * (1.0F / 9));
          if (takes_max) dx[best] += dy;
        }
    }
    const auto same = [](const std::vector<float>& a, const std::vector<float>& b) {
      return std::ranges::equal(a, b, [](float p, float q) {
        return std::bit_cast<std::uint32_t>(p) == std::bit_cast<std::uint32_t>(q) || (std::isnan(p) && std::isnan(q));
      });
    };
    CHECK(same(predict(network, inputs), outputs));
    CHECK(same(input_gradient(network, inputs, by_output), gradient));
  }
}
