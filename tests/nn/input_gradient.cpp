// Tests of derivatives with BatchNorm's running statistics: nn::input_gradient(), and a Trainer whose statistics are
// frozen, against central differences in double.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "nn/fit.hpp"
#include "nn/training/trainer.hpp"
#include "tests/nn/chain.hpp"
#include "tests/nn/lived_in.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

namespace {

struct Case {
  Shape shape;
  const char* architecture;
};

// Smooth, so that no difference crosses a kink.
constexpr Case cases[]{
    {{2, 6, 5},
     "conv 4 3x3 pad 1; batchnorm; tanh; avgpool 2; residual { conv 4 1x1; batchnorm; gelu }; dropout 0.5; fc 3"},
    {{5, 1, 1}, "fc 6; batchnorm; sigmoid; concat { fc 2; batchnorm }; layernorm; fc 3"},
};
constexpr int outputs = 3;

Network<double> in_double(const Network<float>& network) {
  Network<double> copy(network.input_shape(), network.architecture());
  const auto copy_values = [](const auto& from, auto& to) { to.value.assign(from.value.begin(), from.value.end()); };
  for (std::size_t i = 0; i < network.layers().size(); ++i) {
    const Layer<float>& from = network.layers()[i];
    Layer<double>& to = copy.layers()[i];
    for (std::size_t k = 0; k < from.parameters().size(); ++k) copy_values(from.parameters()[k], to.parameters()[k]);
    for (std::size_t k = 0; k < from.statistics().size(); ++k) copy_values(from.statistics()[k], to.statistics()[k]);
  }
  return copy;
}

std::vector<double> statistics_of(const Network<double>& network) {
  std::vector<double> all;
  for (const Layer<double>& layer : network.layers())
    for (const RunningStatistics<double>& s : layer.statistics()) all.insert(all.end(), s.value.begin(), s.value.end());
  return all;
}

/// A frozen Trainer in double, and the sum whose derivatives it computes.
class Frozen {
 public:
  Frozen(const Case& of, int batch)
      : network(in_double(lived_in_network(of.shape, of.architecture))),
        trainer(network, std::max(batch, 2), nullptr, true),
        input(hashed_values<double>(1, static_cast<std::size_t>(batch * of.shape.size()))),
        by_output(hashed_values<double>(2, static_cast<std::size_t>(batch * outputs))) {
    trainer.freeze_statistics();
    trainer.set_batch(batch);
  }
  double sum() {
    load_batch(trainer.input(), input);
    fill_unused_lanes(trainer.input(), std::numeric_limits<double>::quiet_NaN());
    trainer.forward();
    long double total = 0;
    const std::vector<double> output = store_batch(trainer.output());
    for (std::size_t i = 0; i < output.size(); ++i) total += static_cast<long double>(output[i] * by_output[i]);
    return static_cast<double>(total);
  }
  void backward() {
    sum();
    load_batch(trainer.output_diff(), by_output);
    fill_unused_lanes(trainer.output_diff(), std::numeric_limits<double>::quiet_NaN());
    trainer.backward();
  }

  Network<double> network;
  Trainer<double> trainer;
  std::vector<double> input, by_output;
};

}  // namespace

TEST_CASE("a Trainer with frozen statistics: central differences of inputs and parameters, statistics stay") {
  const Threads one_thread(1);
  for (const Case& one : cases) {
    CAPTURE(one.architecture);
    for (const int batch : {1, 18}) {
      CAPTURE(batch);
      Frozen frozen(one, batch);
      const std::vector<double> before = statistics_of(frozen.network);
      frozen.backward();
      // Differences of step 1e-5 err by 1e-10 / 6 of a third derivative, and by rounding of the sum over the step,
      // 1e-11 of it: values of order ten.
      const auto check = [&](std::vector<double>& values, const std::vector<double>& derivatives) {
        for (std::size_t i = 0; i < values.size(); i += 1 + values.size() / 8) {
          constexpr double step = 1e-5;
          const double kept = values[i];
          values[i] = kept + step;
          const double right = frozen.sum();
          values[i] = kept - step;
          const double left = frozen.sum();
          values[i] = kept;
          CHECK(std::abs(derivatives[i] - (right - left) / (2 * step)) <
                2e-8 * std::max(1.0, std::abs(derivatives[i])));
        }
      };
      std::vector<std::vector<double>> gradients;
      for (std::size_t k = 0; k < frozen.network.parameters().size(); ++k)
        gradients.emplace_back(std::as_const(frozen.trainer).gradient(k).begin(),
                               std::as_const(frozen.trainer).gradient(k).end());
      check(frozen.input, store_batch(frozen.trainer.input_diff()));
      for (std::size_t k = 0; k < gradients.size(); ++k) check(frozen.network.parameters()[k]->value, gradients[k]);
      CHECK(statistics_of(frozen.network) == before);
    }
  }
}

TEST_CASE("input_gradient: the derivatives in double, rounded, and the outputs of predict()") {
  for (const Case& one : cases) {
    CAPTURE(one.architecture);
    const Network<float> network = lived_in_network(one.shape, one.architecture);
    Frozen frozen(one, 18);
    frozen.backward();
    const std::vector<float> input(frozen.input.begin(), frozen.input.end()),
        by_output(frozen.by_output.begin(), frozen.by_output.end());
    // Some ten layers of sums of up to 50 terms, each of which rounds by half an epsilon.
    constexpr double tolerance = 10 * 50 * 0.5 * static_cast<double>(std::numeric_limits<float>::epsilon());
    const auto check = [&](const std::vector<float>& found, const std::vector<double>& expected) {
      REQUIRE(found.size() == expected.size());
      double largest = 0;
      for (const double value : expected) largest = std::max(largest, std::abs(value));
      for (std::size_t i = 0; i < found.size(); ++i)
        CHECK(std::abs(static_cast<double>(found[i]) - expected[i]) <= tolerance * largest);
    };
    const std::vector<float> gradient = input_gradient(network, input, by_output);
    check(gradient, store_batch(frozen.trainer.input_diff()));
    frozen.sum();
    check(predict(network, input), store_batch(frozen.trainer.output()));
    // A sample's do not depend on the others; more samples than are computed at once.
    const auto size = static_cast<std::size_t>(one.shape.size());
    const std::span<const float> first = std::span(input).first(size), slope = std::span(by_output).first(outputs);
    CHECK(input_gradient(network, first, slope) ==
          std::vector<float>(gradient.begin(), gradient.begin() + one.shape.size()));
    std::vector<float> many, slopes;
    for (int i = 0; i < 300; ++i) {
      many.insert(many.end(), first.begin(), first.end());
      slopes.insert(slopes.end(), slope.begin(), slope.end());
    }
    const std::vector<float> all = input_gradient(network, many, slopes);
    CHECK(std::ranges::equal(std::span(all).last(size), std::span(gradient).first(size)));
    CHECK(input_gradient(network, {}, {}).empty());
    check_error([&] { input_gradient(network, std::span(input).first(size - 1), slope); }, decid::Code::size_mismatch);
    check_error([&] { input_gradient(network, first, by_output); }, decid::Code::size_mismatch);
  }
}
