// Tests of the layers in nn/: cases computed by hand, memory that is used again, texts and their errors.
// Definitions in nn/layers/layer.hpp, nn/architecture.hpp and nn/kernels/kernels.hpp; derivatives in operations.cpp,
// figures of PyTorch in torch.cpp.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "nn/training/loss.hpp"
#include "nn/training/trainer.hpp"
#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

namespace {

using Values = std::vector<float>;

/// One sample through one layer: its output, and its input's derivative for the output's derivative `diff`.
struct Hand {
  Hand(Shape shape, const std::string& line) : chain(shape, line, 1) {}
  Values forward(const Values& input) {
    load_batch(chain.input(), input);
    chain.forward();
    return store_batch(chain.output());
  }
  Values backward(const Values& diff) {
    load_batch(chain.output_diff(), diff);
    chain.backward();
    return store_batch(chain.input_diff());
  }
  Chain<float> chain;
};

}  // namespace

TEST_CASE("relu: by hand, a NaN stays one") {
  Hand relu({1, 1, 4}, "relu");
  CHECK(relu.forward({-1, 0, 2, -0.0f}) == Values{0, 0, 2, 0});
  CHECK(relu.backward({5, 6, 7, 8}) == Values{0, 0, 7, 0});
  CHECK(std::isnan(relu.forward({std::nanf(""), 0, 0, 0})[0]));
}

// PyTorch's figures have average pools.
TEST_CASE("maximum pooling: by hand, incomplete windows left out") {
  const Values input{1,  5,  2, 9,  //
                     5,  3,  4, 9,  //
                     -1, -2, 9, 9};
  Hand maximum({1, 3, 4}, "maxpool 2");
  CHECK(maximum.forward(input) == Values{5, 9});
  CHECK(maximum.backward({1, 2}) == Values{0, 1, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0});  // the first of equals
  Hand overlapping({1, 3, 4}, "maxpool 2 stride 1");
  CHECK(overlapping.forward(input) == Values{5, 5, 9, 5, 9, 9});
  CHECK(overlapping.backward({1, 2, 4, 8, 16, 32}) == Values{0, 3, 0, 4, 8, 0, 0, 32, 0, 0, 16, 0});
  Hand negative({1, 1, 2}, "maxpool 1x2");
  CHECK(negative.forward({-3, -2}) == Values{-2});
}

// PyTorch's figures (torch.cpp) have the formulas.
TEST_CASE("batchnorm: one value, two, equal ones and NaN in a channel") {
  Hand single({2, 1, 1}, "batchnorm");  // one value a channel: variance 0, and no division by 0
  for (const float v : single.forward({5, -7})) CHECK(std::abs(v) < 7 / std::sqrt(1e-5f) * 1.2e-7f);
  CHECK(single.chain.statistics()[1]->value == Values{0.9f, 0.9f});

  Hand two({1, 1, 2}, "batchnorm");  // mean 3, unbiased variance 8
  two.forward({1, 5});
  CHECK(two.chain.statistics()[1]->value[0] == static_cast<float>(0.9 + 0.1 * 8));

  Hand constant({1, 2, 2}, "batchnorm");
  for (const float v : constant.forward({1e6f, 1e6f, 1e6f, 1e6f})) CHECK(std::abs(v) < 100);
  Hand diverged({1, 1, 2}, "batchnorm");
  CHECK(std::isnan(diverged.forward({1, std::nanf("")})[0]));
}

TEST_CASE("batchnorm: a mean a thousand deviations away costs no more than the input's own rounding") {
  Chain<float> chain({1, 8, 8}, "batchnorm", 32);
  auto values = hashed_values<float>(4, 32 * 64, 1.0, 1000.0);
  double mean = 0, variance = 0;
  for (const float v : values) mean += static_cast<double>(v) / static_cast<double>(values.size());
  for (const float v : values)
    variance += std::pow(static_cast<double>(v) - mean, 2) / static_cast<double>(values.size());
  for (int step = 0; step < 200; ++step) {  // until the running mean, the sums' pivot, is there
    load_batch(chain.input(), values);
    chain.forward();
  }
  const Values output = store_batch(chain.output());
  double worst = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    worst = std::max(worst, std::abs(static_cast<double>(output[i]) -
                                     (static_cast<double>(values[i]) - mean) / std::sqrt(variance + 1e-5)));
  CHECK(worst < 2 * 1000 / std::sqrt(variance) * std::numeric_limits<float>::epsilon());
}

namespace {

constexpr const char* all_layers =
    "conv 18 3x3 pad 1; batchnorm; relu; maxpool 2; conv 5 3x3 stride 2x1 pad 1; batchnorm; relu; avgpool 2 stride 1; "
    "conv 3 1x1; globalavgpool; fc 9; relu; conv 4 3x3 pad 1; fc 3";
constexpr Shape all_shape{2, 10, 9};

Network<float> network_of_all_layers() {
  Network<float> network(all_shape, all_layers);
  network.initialise(11);
  std::uint32_t id = 50;
  for (Layer<float>& layer : network.layers())
    for (RunningStatistics<float>& s : layer.statistics())
      s.value = hashed_values<float>(id++, s.value.size(), 0.5, 1.0);
  return network;
}

Values sample(int number) {
  return hashed_values<float>(100 + static_cast<std::uint32_t>(number), static_cast<std::size_t>(all_shape.size()));
}

/// Outputs in inference of samples [first, first + batch).
Values infer(BatchExecutor<float>& executor, int first, int batch) {
  executor.set_batch(batch);
  for (int n = 0; n < batch; ++n) executor.input().load(n, sample(first + n));
  executor.forward();
  return store_batch(executor.output());
}

struct TrainingStep {
  Values output;
  std::vector<double> parts;
  std::vector<Values> gradients, statistics;
  bool operator==(const TrainingStep&) const = default;
};

/// One training step of `network`, whose trainer it is, without the update; lanes without a sample hold `unused`.
TrainingStep train(Network<float>& network, Trainer<float>& trainer, int batch, float unused = 0.0f) {
  network.initialise(11);
  trainer.set_batch(batch);
  for (int n = 0; n < batch; ++n) trainer.input().load(n, sample(n));
  fill_unused_lanes(trainer.input(), unused);
  trainer.forward();
  TrainingStep step;
  step.output = store_batch(trainer.output());
  step.parts.resize(3 * TensorView<float>::count_blocks(batch));
  fill_unused_lanes(trainer.output(), unused);
  const auto targets = hashed_values<float>(9, static_cast<std::size_t>(batch) * 3);
  squared_errors(trainer.output(), targets, batch, step.parts, trainer.output_diff());
  fill_unused_lanes(trainer.output_diff(), unused);
  trainer.backward();
  for (std::size_t k = 0; k < network.parameters().size(); ++k) {
    const std::span<const float> gradient = trainer.gradient(k);
    step.gradients.emplace_back(gradient.begin(), gradient.end());
  }
  for (const Layer<float>& layer : network.layers())
    for (const RunningStatistics<float>& s : layer.statistics()) step.statistics.push_back(s.value);
  return step;
}

}  // namespace

TEST_CASE("memory: what a larger batch left behind changes nothing") {
  Network<float> used = network_of_all_layers();
  Trainer<float> used_trainer(used, 48);
  train(used, used_trainer, 48);
  const Inference<float> inference(network_of_all_layers());
  BatchExecutor<float> used_executor(inference, 48);
  infer(used_executor, 0, 48);
  for (const int batch : {1, 15, 17, 32}) {
    CAPTURE(batch);
    Network<float> fresh = network_of_all_layers();
    Trainer<float> fresh_trainer(fresh, batch);
    const TrainingStep expected = train(fresh, fresh_trainer, batch);
    train(used, used_trainer, 48);
    CHECK(train(used, used_trainer, batch) == expected);

    BatchExecutor<float> fresh_executor(inference, batch);
    const Values fresh_output = infer(fresh_executor, 3, batch);
    infer(used_executor, 0, 48);
    CHECK(same_bits(infer(used_executor, 3, batch), fresh_output));
  }
}

TEST_CASE("lanes without a sample: NaN there reaches no gradient, statistic or loss") {
  for (const int batch : {1, 15, 17, 40}) {
    CAPTURE(batch);
    Network<float> network = network_of_all_layers();
    Trainer<float> trainer(network, batch);
    const TrainingStep clean = train(network, trainer, batch);
    for (const Values& gradient : clean.gradients)
      for (const float g : gradient) REQUIRE(std::isfinite(g));
    CHECK(train(network, trainer, batch, std::nanf("")) == clean);
    CHECK(train(network, trainer, batch, std::numeric_limits<float>::infinity()) == clean);
    CHECK(train(network, trainer, batch) == clean);  // nor does the NaN stay
  }
}

TEST_CASE("texts: complete, and they parse back to themselves") {
  const std::pair<const char*, const char*> texts[]{
      {"conv 4 3x3", "conv 4 3x3 stride 1x1 pad 0x0"},
      {"conv 4 3 stride 2 pad 1", "conv 4 3x3 stride 2x2 pad 1x1"},
      {" conv\t4  5x3 stride 1x2 pad 4x0 \r", "conv 4 5x3 stride 1x2 pad 4x0"},
      {"conv 4 3x3 pad 1", "conv 4 3x3 stride 1x1 pad 1x1"},
      {"batchnorm", "batchnorm"},
      {"relu", "relu"},
      {"maxpool 2", "maxpool 2x2 stride 2x2"},
      {"maxpool 3x2 stride 1x2", "maxpool 3x2 stride 1x2"},
      {"avgpool 2x4", "avgpool 2x4 stride 2x4"},
      {"avgpool 3 stride 2", "avgpool 3x3 stride 2x2"},
      {"globalavgpool", "globalavgpool"},
      {"statspool", "statspool"},
      {"fc 5", "fc 5"},
  };
  const Shape shape{3, 9, 8};
  for (const auto& [given, complete] : texts) {
    const auto layer = make_layer<float>(shape, given);
    CHECK(layer.text() == complete);
    const auto again = make_layer<double>(shape, layer.text());
    CHECK(again.text() == complete);
    CHECK(again.dst_shape() == layer.dst_shape());
  }
  CHECK(make_layer<float>(shape, "conv 4 5x3 stride 2x3 pad 1x2").dst_shape() == Shape{4, 4, 4});
  CHECK(make_layer<float>(shape, "maxpool 2x3 stride 3x2").dst_shape() == Shape{3, 3, 3});
  CHECK(make_layer<float>(shape, "globalavgpool").dst_shape() == Shape{3, 1, 1});
  CHECK(make_layer<float>(shape, "statspool").dst_shape() == Shape{6, 1, 1});
  CHECK(make_layer<float>(shape, "fc 5").dst_shape() == Shape{5, 1, 1});
}

TEST_CASE("texts: lines that are wrong are refused, with the numbers that are allowed") {
  const Shape shape{3, 6, 5};
  struct Group {
    const char* fact;
    std::vector<std::string> lines;
  };
  const Group groups[]{
      {"",
       {"",
        "softsign",
        "Conv 4 3x3",
        "conv",
        "conv 4",
        "conv 4 3x3 stride",
        "conv 4 3x3 pad",
        "conv 4 3x3 pad 1 stride 2",
        "conv 4 3x3 same",
        "conv 4 3x3 pad 3",
        "conv 4 1x3 pad 1",
        "conv 4 3x3 dilation 3",
        "conv 4 3x3 stride 2 dilation 2",
        "conv 4 3x3 groups 2",
        "batchnorm 3",
        "relu 6",
        "maxpool",
        "maxpool 2 stride",
        "maxpool 2 pad 2",
        "maxpool 2 stride 1 by 1",
        "avgpool 9 pad 1",
        "globalavgpool pad 1",
        "globalavgpool 2",
        "statspool 2",
        "dropout",
        "dropout 1",
        "leakyrelu x",
        "leakyrelu 2",
        "layernorm 3",
        "tanh 1",
        "fc",
        "fc 7 7"}},
      {"from 1 to 4096",
       {"conv 0 3x3", "conv 4097 3x3", "conv -4 3x3", "conv +4 3x3", "conv 4.5 3x3", "conv 99999999999 3x3",
        "conv four 3x3", "maxpool 0", "avgpool 2 stride 0"}},
      {"from 1 to 255",
       {"conv 4 0x3", "conv 4 3x256", "conv 4 3x", "conv 4 x3", "conv 4 3x3x3", "conv 4 3*3", "conv 4 3x3 stride 0"}},
      {"from 0 to 254", {"conv 4 3x3 pad -1"}},
      {"from 1 to 65536", {"fc 0"}},
      {"6x5", {"conv 4 7x3", "conv 4 3x8 pad 1", "maxpool 7x1", "avgpool 1x6"}},
      {"305", {"conv " + std::string(300, '4')}}};
  for (const Group& group : groups)
    for (const std::string& line : group.lines) {
      CAPTURE(line);
      check_error([&] { make_layer<float>(shape, line); }, decid::Code::setting_malformed, group.fact);
    }
  const auto too_large = [](Shape src, const std::string& line, const char* count) {
    check_error([&] { make_layer<float>(src, line); }, decid::Code::setting_malformed, count);
  };
  too_large({4096, 300, 300}, "conv 4096 255x255", "1090938470400 weights");
  too_large({64, 100, 100}, "fc 65536", "41943040000 weights");
  too_large({1, 1000, 1000}, "conv 4096 1x1", "4096000000 outputs");
}
