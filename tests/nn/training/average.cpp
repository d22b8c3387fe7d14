// Tests of nn/training/average.hpp: the average by hand, for weights and running statistics.
#include "nn/training/average.hpp"

#include <doctest/doctest.h>

#include <limits>

#include "nn/network_file.hpp"
#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

namespace {

/// A network whose every weight and statistic is `value`.
Network<float> constant_network(float value) {
  Network<float> network({2, 4, 3}, "conv 3 3x3 pad 1; batchnorm; relu; residual { conv 3 1; batchnorm }; fc 2");
  for (Layer<float>& layer : network.layers()) {
    for (Parameter<float>& p : layer.parameters()) p.value.assign(p.value.size(), value);
    for (RunningStatistics<float>& s : layer.statistics()) s.value.assign(s.value.size(), value);
  }
  return network;
}

}  // namespace

TEST_CASE("move_average: by hand, weights and running statistics alike") {
  Network<float> average = constant_network(1);
  // Step 1: the decay is 2/11 at most; step 8: 9/18; step 1000: the one that is given. Floats: exact, or to rounding.
  move_average(average, constant_network(12), 0.75, 1);
  const Network<float> once = average;
  CHECK(std::abs(once.parameters()[0]->value[0] - 10.0F) < 2e-6F);
  move_average(average, constant_network(20), 0.75, 8);
  CHECK(std::abs(average.parameters()[0]->value[0] - 15.0F) < 2e-6F);
  move_average(average, constant_network(3), 0.75, 1000);
  int statistics = 0;
  for (const Layer<float>& layer : std::as_const(average).layers()) {
    for (const Parameter<float>& p : layer.parameters())
      for (const float v : p.value) CHECK(std::abs(v - 12.0F) < 4e-6F);
    for (const RunningStatistics<float>& s : layer.statistics()) {
      ++statistics;
      for (const float v : s.value) CHECK(std::abs(v - 12.0F) < 4e-6F);
    }
  }
  CHECK(statistics == 4);  // mean and variance of two normalisations
}

TEST_CASE("move_average: decays that average nothing are refused") {
  Network<float> average = constant_network(1);
  for (const double decay : {0.0, 1.0, -0.5, std::numeric_limits<double>::quiet_NaN()})
    check_error([&] { move_average(average, constant_network(2), decay, 1); }, decid::Code::setting_out_of_range);
}

TEST_CASE("network files: a second network in a file is read back, and one that is not there is refused") {
  const Network<float> first = constant_network(1), second = constant_network(2);
  TensorFile file = to_tensors(first);
  add_network(second, "average.", file);
  CHECK(weights_sha256(added_network("average.", first, file, "test")) == weights_sha256(second));
  check_error([&] { added_network("best.", first, file, "test"); }, decid::Code::file_damaged, "test");
  CHECK(weights_sha256(from_tensors(std::move(file), "test")) == weights_sha256(first));
}
