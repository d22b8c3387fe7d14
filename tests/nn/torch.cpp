// Tests of the layers, the loss and a short training against PyTorch: the figures of torch_figures.inc, computed there
// in double by tests/nn/torch_figures.py from the same inputs. A sum of n terms in float errs by epsilon times the sum
// of their magnitudes times, roundings being independent, the root of n: that is each tensor's tolerance.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "nn/training/loss.hpp"
#include "nn/training/optimiser.hpp"
#include "nn/training/trainer.hpp"
#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

namespace {

struct Figure {
  std::string name;
  int length;         ///< of the longest sum behind a value
  double magnitude;   ///< largest sum of absolute values of the terms
  double projection;  ///< all values times hashed(99, index)
  std::vector<double> values;
};

const std::vector<Figure>& figures() {
  static const std::vector<Figure> all{
#include "tests/nn/torch_figures.inc"
  };
  return all;
}

template <class T>
void compare(const std::string& name, const std::vector<T>& values) {
  CAPTURE(name);
  const auto figure = std::find_if(figures().begin(), figures().end(), [&](const Figure& f) { return f.name == name; });
  REQUIRE(figure != figures().end());
  const double tolerance = std::sqrt(figure->length) * std::numeric_limits<float>::epsilon() * figure->magnitude;
  // The figures themselves have 12 digits.
  const auto near = [&](double value, double expected, double allowed) {
    CAPTURE(value);
    CAPTURE(expected);
    CHECK(std::abs(value - expected) <= allowed + 1e-11 * std::abs(expected));
  };
  const std::size_t listed = std::min<std::size_t>(values.size(), 24);
  REQUIRE(figure->values.size() == listed);
  for (std::size_t i = 0; i < listed; ++i) {
    const auto drawn = static_cast<std::size_t>((hashed(77, i) + 1) / 2 * static_cast<double>(values.size()));
    near(static_cast<double>(values[values.size() <= 24 ? i : drawn]), figure->values[i], tolerance);
  }
  double projection = 0;
  for (std::size_t i = 0; i < values.size(); ++i) projection += hashed(99, i) * static_cast<double>(values[i]);
  near(projection, figure->projection, tolerance * std::sqrt(static_cast<double>(values.size())));
}

void set_parameters(const std::vector<Parameter<float>*>& parameters, std::uint32_t id) {
  for (Parameter<float>* p : parameters) {
    const bool weight = p->name == "weight", gamma = p->name == "gamma";
    p->value = hashed_values<float>(id++, p->value.size(), weight || gamma ? 0.5 : 1.0, gamma ? 1.0 : 0.0);
  }
}

void load_hashed(const TensorView<float>& tensor, std::uint32_t id, double scale = 1.0, double offset = 0.0) {
  const auto count = static_cast<std::size_t>(tensor.batch()) * static_cast<std::size_t>(tensor.shape().size());
  load_batch(tensor, hashed_values<float>(id, count, scale, offset));
}

/// Runs forward and backward of case `number` of torch_figures.py, by a Chain or a Trainer.
void check_passes(std::uint32_t number, const std::string& name, const std::vector<Parameter<float>*>& parameters,
                  auto& run) {
  const std::uint32_t first = 100 * number;
  load_hashed(run.input(), first, 1.5, 0.2);
  run.forward();
  compare(name + "/dst", store_batch(run.output()));
  load_hashed(run.output_diff(), first + 1);
  run.backward();
  compare(name + "/diff_src", store_batch(run.input_diff()));
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto& gradient = std::as_const(run).gradient(k);
    compare(name + "/" + parameters[k]->name, std::vector<float>(gradient.begin(), gradient.end()));
  }
}

/// Checks a network with a block.
void check_blocks(std::uint32_t number, const std::string& name, const std::string& text) {
  Network<float> network({3, 5, 4}, text);
  set_parameters(network.parameters(), 100 * number + 10);
  Trainer<float> trainer(network, 17, nullptr, true);
  check_passes(number, name, network.parameters(), trainer);
}

}  // namespace

TEST_CASE("PyTorch: layers") {
  struct Row {
    std::uint32_t number;
    const char* name;
    Shape shape;
    int batch;
    const char* line;
  };
  const Row rows[]{
      {0, "conv1x1", {5, 4, 6}, 3, "conv 7 1x1"},
      {2, "conv3x3pad1", {17, 6, 5}, 16, "conv 18 3x3 pad 1"},
      {4, "conv5x3pad1x2", {2, 8, 9}, 3, "conv 3 5x3 pad 1x2"},
      {6, "conv3x3stride2x1", {3, 8, 7}, 5, "conv 4 3x3 stride 2x1 pad 0x1"},
      {7, "conv5x5stride3pad4", {2, 10, 11}, 16, "conv 3 5x5 stride 3 pad 4"},
      {8, "conv1x1stride2", {3, 7, 8}, 33, "conv 4 1x1 stride 2"},
      {9, "relu", {3, 4, 5}, 17, "relu"},
      {10, "maxpool2", {3, 8, 7}, 17, "maxpool 2"},
      {12, "maxpool2x3", {3, 6, 8}, 16, "maxpool 2x3 stride 1x2"},
      {13, "avgpool2", {3, 8, 7}, 17, "avgpool 2"},
      {15, "avgpool2stride3", {3, 8, 9}, 16, "avgpool 2 stride 3"},
      {16, "globalavgpool", {5, 7, 6}, 19, "globalavgpool"},
      {17, "fc", {4, 5, 6}, 19, "fc 7"},
      {18, "fcmany", {3, 1, 2}, 35, "fc 40"},
      {20, "depthwise", {5, 7, 6}, 3, "conv 5 3x3 stride 2 pad 1 groups 5"},
      {21, "dilation2x3", {4, 9, 8}, 17, "conv 6 3x2 pad 2x1 groups 2 dilation 2x3"},
      {22, "dilation5x1", {3, 12, 1}, 16, "conv 4 3x1 pad 4x0 dilation 5x1"},
      {23, "maxpool3pad1", {3, 9, 8}, 17, "maxpool 3 stride 2 pad 1"},
      {24, "avgpool3pad1", {3, 9, 8}, 5, "avgpool 3 stride 2 pad 1"},
      {25, "leakyrelu", {3, 4, 5}, 17, "leakyrelu 0.125"},
      {26, "tanh", {3, 4, 5}, 17, "tanh"},
      {27, "sigmoid", {3, 4, 5}, 17, "sigmoid"},
      {28, "gelu", {3, 4, 5}, 17, "gelu"},
      {29, "layernorm", {6, 4, 5}, 19, "layernorm"},
      {30, "layernormflat", {33, 1, 1}, 3, "layernorm"},
      {31, "statspool", {5, 7, 6}, 19, "statspool"},
  };
  for (const Row& row : rows) {
    Chain<float> chain(row.shape, row.line, row.batch);
    set_parameters(chain.parameters(), 100 * row.number + 10);
    check_passes(row.number, row.name, chain.parameters(), chain);
  }
}

TEST_CASE("PyTorch: residual and concat") {
  check_blocks(32, "residual", "residual { conv 3 3x3 pad 1; tanh }");
  check_blocks(33, "concat", "concat { conv 2 1x1; sigmoid }");
}

TEST_CASE("PyTorch: batch normalisation, three steps of training and inference") {
  const Shape shape{9, 5, 6};
  Chain<float> chain(shape, "batchnorm", 19);
  set_parameters(chain.parameters(), 5000);
  for (std::uint32_t step = 0; step < 3; ++step) {
    const std::string name = "batchnorm" + std::to_string(step) + "/";
    auto values = hashed_values<float>(5010 + step, static_cast<std::size_t>(19 * shape.size()));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += static_cast<float>(i / 30 % 9) * 0.25f;
    load_batch(chain.input(), values);
    chain.forward();
    load_hashed(chain.output_diff(), 5020 + step);
    chain.backward();
    compare(name + "dst", store_batch(chain.output()));
    compare(name + "diff_src", store_batch(chain.input_diff()));
    for (std::size_t k = 0; k < 2; ++k) compare(name + chain.parameters()[k]->name, chain.gradient(k));
    for (const RunningStatistics<float>* s : chain.statistics()) compare(name + s->name, s->value);
  }
  load_hashed(chain.input(), 5030);
  chain.infer();
  compare("batchnorm/inference", store_batch(chain.output()));
}

TEST_CASE("PyTorch: a network trained for five steps with momentum and weight decay") {
  constexpr int batch = 19, steps = 5;
  Network<float> network({2, 12, 10},
                         "conv 4 3x3 pad 1; batchnorm; relu; maxpool 2; conv 6 3x3 stride 2x1 pad 1; batchnorm; relu; "
                         "avgpool 2; fc 3");
  Trainer<float> trainer(network, batch);
  const std::string lines[] = {"0.", "0.", "1.", "1.", "4.", "4.", "5.", "5.", "8.", "8."};  // of each parameter
  REQUIRE(network.parameters().size() == std::size(lines));
  for (std::size_t k = 0; k < std::size(lines); ++k)
    set_parameters({network.parameters()[k]},
                   8010 + 2 * static_cast<std::uint32_t>(lines[k][0] - '0') + static_cast<std::uint32_t>(k % 2));
  const auto targets = hashed_values<float>(8001, batch * 3);
  std::vector<double> losses, parts(6);
  const auto optimiser = sgd({.momentum = 0.875, .weight_decay = 0.03125});
  OptimiserState state = begin(*optimiser, network);
  for (int step = 0; step < steps; ++step) {
    load_hashed(trainer.input(), 8000, 1.5, 0.2);
    trainer.forward();
    squared_errors(trainer.output(), targets, batch, parts, trainer.output_diff());
    losses.push_back(std::accumulate(parts.begin(), parts.end(), 0.0) / (batch * 3));
    trainer.backward();
    if (step == 0)
      for (std::size_t k = 0; k < std::size(lines); ++k) {
        const std::span<const float> gradient = trainer.gradient(k);
        compare("network/gradient" + lines[k] + network.parameters()[k]->name,
                std::vector<float>(gradient.begin(), gradient.end()));
      }
    update(*optimiser, network, trainer.gradients(), 0.0625, state);
  }
  compare("network/losses", losses);
  for (std::size_t k = 0; k < std::size(lines); ++k)
    compare("network/" + lines[k] + network.parameters()[k]->name, network.parameters()[k]->value);
  std::vector<const RunningStatistics<float>*> statistics;
  for (const Layer<float>& layer : network.layers())
    for (const RunningStatistics<float>& s : layer.statistics()) statistics.push_back(&s);
  REQUIRE(statistics.size() == 4);
  for (std::size_t k = 0; k < 4; ++k)
    compare((k < 2 ? "network/1." : "network/5.") + statistics[k]->name, statistics[k]->value);
  const Inference<float> inference(network);
  BatchExecutor<float> executor(inference, batch);
  load_hashed(executor.input(), 8002, 1.5, 0.2);
  executor.forward();
  compare("network/inference", store_batch(executor.output()));
}
