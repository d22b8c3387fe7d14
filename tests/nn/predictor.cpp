// Tests of nn/predictor.hpp: few images and many alike, features, activations, threads that share an Inference.
#include "nn/predictor.hpp"

#include <doctest/doctest.h>

#include <thread>

#include "tests/nn/chain.hpp"
#include "tests/nn/lived_in.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

namespace {

constexpr const char* conv_text = "conv 6 3x3 pad 1; batchnorm; relu; maxpool 2; conv 18 3x3 pad 1; batchnorm; relu";
const std::string network_text = std::string(conv_text) + "; fc 21; batchnorm; relu; fc 3";
const std::string features_text = std::string(conv_text) + "; fc 21; batchnorm; relu";
constexpr Shape shape{2, 12, 10};

std::vector<float> images_of(int count) {
  std::vector<float> images;
  for (int i = 0; i < count; ++i) {
    const std::vector<float> image = random_image(shape, static_cast<std::uint64_t>(i));
    images.insert(images.end(), image.begin(), image.end());
  }
  return images;
}

/// Outputs of `count` images, one call each.
std::vector<float> one_by_one(Predictor& predictor, std::span<const float> images, std::size_t count) {
  const std::size_t size = images.size() / count,
                    outputs = static_cast<std::size_t>(predictor.inference().output_shape().size());
  std::vector<float> all(count * outputs);
  for (std::size_t i = 0; i < count; ++i)
    predictor.run(images.subspan(i * size, size), std::span(all).subspan(i * outputs, outputs));
  return all;
}

}  // namespace

TEST_CASE("predictor: lanes or batches, any number of images, any largest batch: the same bits") {
  const auto inference = std::make_shared<const Inference<float>>(lived_in_network(shape, network_text));
  constexpr int most = 150;  // two batches of 64, and some
  const std::vector<float> images = images_of(most);
  Predictor few(inference, 1);
  const std::vector<float> expected = one_by_one(few, images, most);
  for (const int largest : {1, 8, 9, 20, 64, 1000}) {
    Predictor predictor(inference, largest);
    for (const std::size_t count : {1U, 8U, 9U, 16U, 17U, 64U, 65U, 150U}) {
      CAPTURE(largest);
      CAPTURE(count);
      std::vector<float> outputs(3 * count);
      predictor.run(std::span(images).first(count * 240), outputs);
      CHECK(std::equal(outputs.begin(), outputs.end(), expected.begin()));
    }
    predictor.run({}, {});
  }
}

TEST_CASE("predictor: features are the outputs of a network that ends before its last layer") {
  Network<float> network = lived_in_network(shape, network_text);
  Network<float> start(shape, features_text);
  for (std::size_t i = 0; i < start.layers().size(); ++i) start.layers()[i] = network.layers()[i];
  for (const int largest : {1, 64}) {
    Predictor predictor(network, largest), truncated(start, largest);
    REQUIRE(predictor.feature_count() == 21);
    for (const std::size_t count : {3U, 40U}) {
      const std::vector<float> images = images_of(static_cast<int>(count));
      std::vector<float> outputs(3 * count), alone(3 * count), features(21 * count), wanted(21 * count);
      predictor.run(images, outputs, features);
      predictor.run(images, alone);
      truncated.run(images, wanted);
      CHECK(features == wanted);
      CHECK(outputs == alone);
      CHECK(features[0] != features[21]);
    }
  }
  // Channel, row, column where the last layer reads planes.
  Predictor planes(lived_in_network(shape, std::string(conv_text) + "; fc 3"), 1);
  Predictor convolutions(lived_in_network(shape, conv_text), 1);
  REQUIRE(planes.feature_count() == 18 * 6 * 5);
  std::vector<float> outputs(3), features(540), wanted(540);
  planes.run(images_of(1), outputs, features);
  convolutions.run(images_of(1), wanted);
  CHECK(features == wanted);
  CHECK(Inference<float>(Network<float>(shape, "fc 3")).feature_count() == 0);
  CHECK(Inference<float>(Network<float>(shape, "conv 3 12x10")).feature_count() == 0);
  CHECK(Inference<float>(Network<float>(shape, "fc 3; relu")).feature_count() == 0);
}

TEST_CASE("predictor: two threads share one Inference") {
  const auto inference = std::make_shared<const Inference<float>>(lived_in_network(shape, network_text));
  constexpr std::size_t count = 40;
  const std::vector<float> images = images_of(count);
  Predictor here(inference, 1);
  const std::vector<float> expected = one_by_one(here, images, count);
  std::vector<std::vector<float>> outputs(2, std::vector<float>(3 * count));
  std::vector<std::thread> threads;
  for (std::vector<float>& mine : outputs)
    threads.emplace_back([&] {
      Predictor predictor(inference, static_cast<int>(count));
      for (int round = 0; round < 20; ++round) {
        std::fill(mine.begin(), mine.end(), 0.0F);
        predictor.run(images, mine);
        if (mine != expected) return;
        std::fill(mine.begin(), mine.end(), 0.0F);
        predictor.run(std::span(images).first(240), std::span(mine).first(3));
        predictor.run(std::span(images).subspan(240), std::span(mine).subspan(3));
        if (mine != expected) return;
      }
    });
  for (std::thread& thread : threads) thread.join();
  CHECK(outputs[0] == expected);
  CHECK(outputs[1] == expected);
}

TEST_CASE("predictor: an Inference is what the network was, not what it becomes") {
  Network<float> network = lived_in_network(shape, network_text);
  Predictor predictor(network, 1);
  std::vector<float> before(3), after(3), changed(3);
  predictor.run(images_of(1), before);
  network.initialise(2);
  predictor.run(images_of(1), after);
  CHECK(after == before);
  Predictor(network, 1).run(images_of(1), changed);
  CHECK(changed != before);
}

TEST_CASE("predictor: a layer's output is that of a network that ends there") {
  Network<float> network = lived_in_network(shape, network_text);
  Predictor predictor(network, 20);
  for (std::size_t layer = 0; layer < network.layers().size(); ++layer) {
    CAPTURE(layer);
    // A convolution's is its output in inference, BatchNorm's scale and shift included.
    const bool folded = std::holds_alternative<Conv2d>(network.layers()[layer].kind());
    std::string text;
    for (std::size_t i = 0; i <= layer; ++i) text += network.layers()[i].text() + "\n";
    if (folded) text += "batchnorm";
    Network<float> start(shape, text);
    for (std::size_t i = 0; i <= layer; ++i) start.layers()[i] = network.layers()[i];
    if (folded) {
      Layer<float>& norm = start.layers()[layer + 1];
      for (std::size_t k = 0; k < 2; ++k) {
        norm.parameters()[k].value = network.layers()[layer + 1].parameters()[k].value;
        norm.statistics()[k].value = network.layers()[layer + 1].statistics()[k].value;
      }
    }
    Predictor truncated(start, 20);
    const auto size = static_cast<std::size_t>(start.output_shape().size());
    REQUIRE(network.layers()[layer].dst_shape() == start.output_shape());
    const std::vector<float> images = images_of(20);
    std::vector<float> seen(size), wanted(20 * size);
    truncated.run(images, wanted);
    for (const std::size_t sample : {0U, 15U, 17U}) {
      predictor.activation(layer, std::span(images).subspan(sample * 240, 240), seen);
      CHECK(std::equal(seen.begin(), seen.end(), wanted.begin() + static_cast<std::ptrdiff_t>(sample * size)));
    }
  }
  std::vector<float> output(3), last(3);
  predictor.run(images_of(1), output);
  predictor.activation(network.layers().size() - 1, images_of(1), last);
  CHECK(last == output);
}

TEST_CASE("predictor: wrong use") {
  const Network<float> network({1, 4, 4}, "fc 2; fc 2");
  check_error([&] { Predictor(network, 0); }, decid::Code::setting_out_of_range, "of 0");
  Predictor predictor(network, 1);
  std::vector<float> image(16), output(2), two(4);
  const auto refused = [&](std::span<const float> images, std::span<float> outputs, std::span<float> features,
                           const char* fact) {
    check_error([&] { predictor.run(images, outputs, features); }, decid::Code::size_mismatch, fact);
  };
  CHECK_NOTHROW(predictor.run(image, output, output));
  refused(std::span(image).first(15), output, {}, "15 values");
  refused(image, std::span(output).first(1), {}, "1 outputs");
  refused(image, two, {}, "4 outputs");
  refused(image, output, two, "4 features");
  Predictor single_layer(Network<float>({1, 4, 4}, "fc 2"), 1);
  check_error([&] { single_layer.run(image, output, output); }, decid::Code::size_mismatch, "2 features");
  check_error([&] { predictor.activation(2, image, output); }, decid::Code::setting_out_of_range, "layer 2");
  check_error([&] { predictor.activation(0, image, two); }, decid::Code::size_mismatch);
  check_error([&] { predictor.activation(0, std::span(image).first(15), output); }, decid::Code::size_mismatch);
}
