// One sample at a time: the same bits as in a batch, for every kind of layer and instruction set.
#include "nn/single.hpp"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>

#include "nn/training/batch.hpp"
#include "tests/nn/lived_in.hpp"

namespace decid::nn {

using namespace testing;

namespace {

constexpr const char* small_network =
    "conv 8 3x3 pad 1; batchnorm; relu; avgpool 2; conv 17 3x3 pad 1; batchnorm; relu; fc 7";
constexpr const char* odd_network =
    "conv 40 5x5 stride 2 pad 2; batchnorm; relu; maxpool 2; conv 33 3x1 stride 1x2 pad 1x0; relu; maxpool 2 stride 1; "
    "conv 20 1x1; batchnorm; globalavgpool; fc 7";
constexpr const char* normalised_input =
    "batchnorm; conv 3 2x3; avgpool 3 stride 2; batchnorm; relu; fc 20; relu; fc 5";
constexpr const char* statistics_network = "conv 19 3x1 stride 2x1; batchnorm; relu; statspool; fc 20; relu; fc 5";
constexpr const char* dense_network = "fc 33; batchnorm; relu; fc 2";

}  // namespace

TEST_CASE("lanes: a sample alone has the bits that it has in a batch") {
  for (const char* architecture : {small_network, odd_network, normalised_input, statistics_network, dense_network})
    for (const Shape shape : {Shape{2, 21, 30}, Shape{18, 13, 13}}) {
      CAPTURE(architecture);
      const Inference<float> inference(lived_in_network(shape, architecture));
      constexpr int batch = 5;
      BatchExecutor<float> executor(inference, batch);
      SingleExecutor single(inference);
      for (int i = 0; i < batch; ++i) executor.input().load(i, random_image(shape, static_cast<std::uint64_t>(i)));
      executor.forward();
      const auto outputs = static_cast<std::size_t>(inference.output_shape().size());
      std::vector<float> together(outputs), alone(outputs);
      for (int round = 0; round < 2; ++round)
        for (int i = 0; i < batch; ++i) {
          executor.output().store(i, together);
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
  const Network<float> network = lived_in_network(shape, odd_network);
  const Inference<float> inference(network);
  CHECK(inference.bytes() > 2 * 4 * network.parameter_count());
  CHECK(SingleExecutor(inference).memory_bytes() >= sizeof(float) * lanes * 14 * 29);  // the input's bytes
  // The kernels themselves, on the numbers of one layer.
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
    CHECK(run(kernels_for(isa)) == expected);
  }
}

}  // namespace decid::nn
