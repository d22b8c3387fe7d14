// One sample at a time: the same bits as in a batch, for every kind of layer and instruction set.
#include "nn/single.hpp"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>

#include "base/error.hpp"
#include "base/random.hpp"

namespace decid::nn {
namespace {

/// A network with weights, BatchNorm parameters and statistics that are not what they start as.
Network<float> lived_in_network(Shape input, const std::string& architecture) {
  Network<float> network(input, architecture);
  network.initialise(9);
  std::uint64_t item = 100;
  for (const auto& layer : network.layers()) {
    for (Parameter<float>* p : layer->parameters())
      for (std::size_t i = 0; p->fan_in == 0 && i < p->value.size(); ++i)
        p->value[i] += 0.3F * static_cast<float>(Random(1, Stream::weights, item).normal(i));
    for (Statistic<float>* s : layer->statistics()) {
      ++item;
      for (std::size_t i = 0; i < s->value.size(); ++i)
        s->value[i] = static_cast<float>(Random(1, Stream::weights, item).uniform(i, 0.2, 1.5));
    }
    ++item;
  }
  return network;
}

std::vector<float> random_image(const Shape& shape, std::uint64_t item) {
  std::vector<float> image(static_cast<std::size_t>(shape.size()));
  for (std::size_t i = 0; i < image.size(); ++i)
    image[i] = static_cast<float>(Random(2, Stream::weights, item).normal(i));
  return image;
}

constexpr const char* small_network =
    "conv 8 3x3 pad 1; batchnorm; relu; avgpool 2; conv 17 3x3 pad 1; batchnorm; relu; fc 7";
constexpr const char* odd_network =
    "conv 40 5x5 stride 2 pad 2; batchnorm; relu; maxpool 2; conv 33 3x1 stride 1x2 pad 1x0; relu; maxpool 2 stride 1; "
    "conv 20 1x1; batchnorm; globalavgpool; fc 7";
constexpr const char* normalised_input =
    "batchnorm; conv 3 2x3; avgpool 3 stride 2; batchnorm; relu; fc 20; relu; fc 5";
constexpr const char* dense_network = "fc 33; batchnorm; relu; fc 2";

}  // namespace

TEST_CASE("lanes: a sample alone has the bits that it has in a batch") {
  for (const char* architecture : {small_network, odd_network, normalised_input, dense_network})
    for (const Shape shape : {Shape{2, 21, 30}, Shape{18, 13, 13}}) {
      CAPTURE(architecture);
      Network<float> network = lived_in_network(shape, architecture);
      constexpr int batch = 5;
      network.plan(batch, Mode::inference);
      SingleNetwork single(network);
      network.set_batch(batch);
      for (int i = 0; i < batch; ++i) network.input().load(i, random_image(shape, static_cast<std::uint64_t>(i)));
      network.forward();
      const auto outputs = static_cast<std::size_t>(network.output_shape().size());
      std::vector<float> together(outputs), alone(outputs);
      for (int round = 0; round < 2; ++round)
        for (int i = 0; i < batch; ++i) {
          network.output().store(i, together);
          single.run(random_image(shape, static_cast<std::uint64_t>(i)), alone);
          for (std::size_t o = 0; o < outputs; ++o) {
            CHECK(std::isfinite(alone[o]));
            CHECK(std::bit_cast<std::uint32_t>(alone[o]) == std::bit_cast<std::uint32_t>(together[o]));
          }
        }
    }
}

TEST_CASE("lanes: every instruction set computes a single sample alike") {
  const Shape shape{3, 14, 29};
  Network<float> network = lived_in_network(shape, odd_network);
  network.plan(1, Mode::inference);
  const SingleNetwork packed(network);
  CHECK(packed.weight_bytes() > 4 * network.parameter_count());
  CHECK(packed.activation_bytes() > 0);
  // The kernels themselves, on one layer's worth of numbers.
  constexpr int taps = 27, columns = 29, blocks = 3;
  std::vector<float> src(4000), weight(static_cast<std::size_t>(blocks * taps * lanes)), bias(blocks * lanes);
  for (std::size_t i = 0; i < src.size(); ++i) src[i] = static_cast<float>(Random(3, Stream::weights, 1).normal(i));
  for (std::size_t i = 0; i < weight.size(); ++i)
    weight[i] = static_cast<float>(Random(3, Stream::weights, 2).normal(i));
  for (std::size_t i = 0; i < bias.size(); ++i) bias[i] = static_cast<float>(Random(3, Stream::weights, 3).normal(i));
  std::vector<std::ptrdiff_t> offset;
  for (int t = 0; t < taps; ++t) offset.push_back((t * 37) % 211);
  const auto run = [&](const Kernels<float>& k) {
    std::vector<float> dst(static_cast<std::size_t>(blocks * 2 * columns * lanes), -1.0F);
    const SingleConv<float> conv{
        2,           columns,    src.data(),          1000,           32, offset.data(), taps, weight.data(),
        bias.data(), dst.data(), 2 * columns * lanes, columns * lanes};
    k.conv2d_single(conv, 0, blocks);
    return dst;
  };
  const std::vector<float> expected = run(reference_kernels<float>());
  for (const Isa isa : available_isas()) {
    CAPTURE(name(isa));
    CHECK(run(kernels_of(isa)) == expected);
  }
}

TEST_CASE("single-sample network: wrong use") {
  Network<float> network({1, 4, 4}, "fc 2");
  CHECK_THROWS_WITH_AS(SingleNetwork{network}, doctest::Contains("not planned"), Error);
  network.plan(1, Mode::training);
  CHECK_THROWS_WITH_AS(SingleNetwork{network}, doctest::Contains("not planned"), Error);
  network.plan(1, Mode::inference);
  SingleNetwork single(network);
  std::vector<float> image(16), output(2);
  CHECK_THROWS_WITH_AS(single.run(std::span(image).first(15), output), doctest::Contains("15"), Error);
  CHECK_THROWS_WITH_AS(single.run(image, std::span(output).first(1)), doctest::Contains("room for 1"), Error);
}

}  // namespace decid::nn
