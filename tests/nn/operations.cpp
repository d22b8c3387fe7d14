// Gradients of all layers by finite differences. Layers that are one file each, residual, concat and a layer that is
// registered here: inference and training, batches and single samples, threads.
#include <doctest/doctest.h>
#include <omp.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "nn/fit.hpp"
#include "nn/operation.hpp"
#include "nn/predictor.hpp"
#include "nn/training/trainer.hpp"
#include "tests/nn/chain.hpp"
#include "tests/thread_ranks.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

namespace {

/// y = scale x^3, with the scale as a parameter of each channel: a layer from outside.
class Cube final : public OperationOf<Cube> {
 public:
  explicit Cube(Shape shape) : OperationOf(shape, shape) {}
  std::string text() const override { return "cube"; }
  std::vector<OperationParameter> parameters() const override { return {{"scale", {src().channels}, 0, 0.5}}; }

  template <class T>
  void forward_pass(const ForwardPass<T>& pass) const {
    each(pass.src, [&](int block, int c, int i, int k) {
      const T x = pass.src.row(block, c, i)[k];
      pass.dst.row(block, c, i)[k] = scale(pass.parameters, c) * x * x * x;
    });
  }
  template <class T>
  void backward_pass(const BackwardPass<T>& pass) const {
    for (int block = 0; block < pass.src.blocks(); ++block)
      for (int c = 0; c < src().channels; ++c) pass.gradient(0, block)[c] = 0;
    each(pass.src, [&](int block, int c, int i, int k) {
      const T x = pass.src.row(block, c, i)[k], dy = pass.diff_dst.row(block, c, i)[k];
      if (k % lanes < pass.src.valid_lanes(block)) pass.gradient(0, block)[c] += dy * x * x * x;
      if (pass.diff_src != nullptr) pass.diff_src->row(block, c, i)[k] = 3 * scale(pass.parameters, c) * x * x * dy;
    });
  }

 private:
  template <class T>
  static T scale(std::span<const std::span<const T>> parameters, int c) {
    return parameters[0][static_cast<std::size_t>(c)];
  }
  template <class T, class Body>
  void each(const TensorView<const T>& x, const Body& body) const {
    for_each_plane(x.blocks(), src().channels, [&](int block, int c) {
      for (int i = 0; i < src().rows; ++i)
        for (int k = 0; k < src().columns * lanes; ++k) body(block, c, i, k);
    });
  }
};

OperationPointer parse_cube(Shape src, Words&) {
  return std::make_shared<Cube>(src);
}

void register_cube() {
  register_layer("cube", parse_cube);
}

struct Case {
  Shape shape;
  const char* text;
};
const std::vector<Case>& cases() {
  register_cube();
  static const std::vector<Case> all{
      {{3, 4, 5}, "leakyrelu"},
      {{3, 4, 5}, "leakyrelu 0.2"},
      {{3, 4, 5}, "tanh"},
      {{3, 4, 5}, "sigmoid"},
      {{3, 4, 5}, "gelu"},
      {{3, 4, 5}, "layernorm"},
      {{9, 1, 1}, "layernorm"},
      {{3, 4, 5}, "dropout 0.25"},
      {{3, 4, 5}, "cube"},
      {{2, 7, 5}, "maxpool 3 stride 2 pad 1"},
      {{9, 5, 6}, "maxpool 2x3 stride 1x2 pad 0x2"},
      {{2, 7, 5}, "avgpool 3 stride 2 pad 1"},
      {{2, 2, 2}, "avgpool 4 stride 2 pad 2"},
      {{4, 6, 5}, "conv 6 3x3 pad 1 groups 2"},
      {{4, 6, 5}, "conv 8 3x2 stride 2x1 groups 4"},
      {{34, 3, 2}, "conv 34 2x2 pad 1 groups 2"},
      {{2, 9, 8}, "conv 3 3x3 pad 2 dilation 2"},
      {{2, 11, 3}, "conv 3 3x1 pad 3x0 dilation 3x1"},
      {{2, 4, 3}, "conv 3 3x1 pad 5x0 dilation 5x1"},
      {{1, 12, 1}, "conv 2 2x1 dilation 7x1"},
      {{2, 5, 9}, "conv 2 1x3 stride 1x2 pad 0x1 dilation 1x3"},
      {{4, 8, 7}, "conv 4 3x2 pad 2x1 groups 2 dilation 2x3"},
      {{2, 6, 5}, "conv 4 3x3 pad 1; residual { conv 4 3x3 pad 1; batchnorm; relu; conv 4 1x1 }; relu; fc 3"},
      {{2, 6, 5}, "residual { tanh }; concat { conv 3 3x3 pad 1; residual { sigmoid } }; conv 2 3x3 pad 1; fc 3"},
      {{3, 1, 1}, "fc 5; concat { fc 4; tanh; concat { fc 2 } }; layernorm; fc 2"},
  };
  return all;
}

std::size_t size(const Shape& shape) {
  return static_cast<std::size_t>(shape.size());
}

/// Mean square of output - target over all values, for values of a Trainer's input and parameters.
class Objective {
 public:
  Objective(const Case& one, int batch)
      : network_(one.shape, one.text),
        trainer_(network_, batch, nullptr, true),
        batch_(static_cast<std::size_t>(batch)) {
    std::uint32_t id = 3;
    for (Parameter<double>* p : network_.parameters())
      p->value = hashed_values<double>(id++, p->value.size(), 0.7, p->name == "gamma" ? 1.0 : 0.0);
    input = hashed_values<double>(1, batch_ * size(one.shape), 1.3, 0.1);
    target_ = hashed_values<double>(2, batch_ * size(network_.output_shape()));
    trainer_.set_random(5, 7);
    for (const Layer<double>& layer : network_.layers())
      for (const RunningStatistics<double>& s : layer.statistics()) statistics_.push_back(s.value);
  }

  double loss() {
    std::size_t k = 0;  // running statistics are pivots: they stay, or differences would see them move
    for (Layer<double>& layer : network_.layers())
      for (RunningStatistics<double>& s : layer.statistics()) s.value = statistics_[k++];
    load_batch(trainer_.input(), input);
    fill_unused_lanes(trainer_.input(), std::numeric_limits<double>::quiet_NaN());
    trainer_.forward();
    const std::vector<double> output = store_batch(trainer_.output());
    long double sum = 0;
    std::vector<double> diff;
    for (std::size_t i = 0; i < output.size(); ++i) {
      const double error = output[i] - target_[i];
      sum += static_cast<long double>(error) * static_cast<long double>(error);
      diff.push_back(2 * error / static_cast<double>(output.size()));
    }
    load_batch(trainer_.output_diff(), diff);
    fill_unused_lanes(trainer_.output_diff(), std::numeric_limits<double>::quiet_NaN());
    return static_cast<double>(sum / static_cast<long double>(output.size()));
  }
  /// After loss(): gradients of the parameters, then that of the input.
  std::vector<std::vector<double>> gradients() {
    trainer_.backward();
    std::vector<std::vector<double>> all;
    for (std::size_t k = 0; k < network_.parameters().size(); ++k)
      all.emplace_back(trainer_.gradient(k).begin(), trainer_.gradient(k).end());
    all.push_back(store_batch(trainer_.input_diff()));
    return all;
  }
  std::vector<std::vector<double>*> values() {
    std::vector<std::vector<double>*> all;
    for (Parameter<double>* p : network_.parameters()) all.push_back(&p->value);
    all.push_back(&input);
    return all;
  }

  std::vector<double> input;

 private:
  Network<double> network_;
  Trainer<double> trainer_;
  std::size_t batch_;
  std::vector<double> target_;
  std::vector<std::vector<double>> statistics_;
};

}  // namespace

// Differences of step h = 1e-5 err by h^2 / 6 of a third derivative, and by rounding of the loss over h, 1e-11; a kink
// of a maximum or a leaky ReLU that lies within h of a value, one in 1e5, would show as a gross error. Sanitizers see
// the same loops at few values; 19 samples are a full block of lanes and one that is not.
#ifdef DECID_SANITIZED
constexpr std::size_t varied_values = 2;
constexpr int batches[] = {19};
#else
constexpr std::size_t varied_values = 25;
constexpr int batches[] = {3, 19};
#endif
static double worst_gradient(const Case& one, int batch) {
  Objective objective(one, batch);
  objective.loss();
  const std::vector<std::vector<double>> gradients = objective.gradients();
  const auto values = objective.values();
  REQUIRE(gradients.size() == values.size());
  double worst = 0;
  for (std::size_t t = 0; t < values.size(); ++t)
    for (std::size_t n = 0; n < std::min(values[t]->size(), varied_values); ++n) {
      const std::size_t i = n * 7919 % values[t]->size();
      double& value = (*values[t])[i];
      const double kept = value, step = 1e-5;
      value = kept + step;
      const double right = objective.loss();
      value = kept - step;
      const double left = objective.loss();
      value = kept;
      const double error = std::abs(gradients[t][i] - (right - left) / (2 * step));
      worst = std::isnan(error) ? std::numeric_limits<double>::infinity() : std::max(worst, error);
    }
  return worst;
}

TEST_CASE("operations: gradients are differences of the loss, parameters' and input's") {
  const Threads one_thread(1);
  // PyTorch's figures and tests/nn/kernels.cpp have more geometries of each kind.
  std::vector<Case> all{{{1, 6, 7}, "conv 3 5x5 pad 4"},
                        {{2, 8, 9}, "conv 3 2x4 stride 3x2 pad 1x3"},
                        {{2, 3, 4}, "conv 3 3x4"},
                        {{17, 2, 3}, "conv 18 2x2 pad 1"},  // more channels than a group
                        {{9, 4, 1}, "batchnorm"},
                        {{3, 4, 5}, "fc 5; relu"},
                        {{2, 5, 7}, "maxpool 2 stride 3"},  // windows leave values out
                        {{9, 5, 6}, "avgpool 2x3 stride 1x2"},
                        {{3, 4, 5}, "globalavgpool"},
                        {{9, 7, 1}, "statspool"},
                        {{9, 1, 1}, "fc 34"},                          // more outputs than a group
                        {{2, 3, 2}, "fc 3; conv 2 3x3 pad 1; fc 2"}};  // outputs with a halo
  all.insert(all.end(), cases().begin(), cases().end());
  for (const Case& one : all)
    for (const int batch : batches) {
      CAPTURE(one.text);
      CAPTURE(batch);
      CHECK(worst_gradient(one, batch) < 2e-8);
    }
}

// A relu works in the memory of the layer before it where that layer allows it, and a batchnorm writes its derivative
// over its input. Both must leave the outputs that the layer before reads in backward. The limit is higher than above
// because the cube's third derivative is large behind a batchnorm.
TEST_CASE("gradients: every layer before a relu, and before a relu and a batchnorm") {
  const Threads one_thread(1);
  std::vector<std::string> lines{"conv 4 3x3 pad 1",
                                 "fc 9",
                                 "batchnorm",
                                 "maxpool 2",
                                 "avgpool 2",
                                 "globalavgpool",
                                 "statspool",
                                 "batchnorm; relu",
                                 "residual { tanh }",
                                 "concat { sigmoid }",
                                 "conv 4 1x1; batchnorm; maxpool 2"};
  for (const Case& one : cases())
    if (std::string(one.text).find(';') == std::string::npos && std::string(one.text).find('{') == std::string::npos)
      lines.emplace_back(one.text);
  for (const std::string& line : lines)
    for (const char* behind : {"; relu", "; relu; batchnorm", "; relu; residual { relu; batchnorm }"}) {
      const std::string text = line + behind;
      CAPTURE(text);
      CHECK(worst_gradient({{4, 8, 7}, text.c_str()}, 5) < 1e-7);
    }
}

TEST_CASE("operations: single samples, batches and threads give the same bits; the text makes the same network") {
  const Threads kept(omp_get_max_threads());
  for (const Case& one : cases()) {
    CAPTURE(one.text);
    Network net(one.shape, one.text);
    net.initialise(3);
    const Network copy(one.shape, net.architecture());
    CHECK(copy.architecture() == net.architecture());
    REQUIRE(copy.parameter_count() == net.parameter_count());
    const auto inputs = hashed_values<float>(1, 19 * size(one.shape));
    omp_set_num_threads(1);
    const std::vector<float> together = predict(net, inputs);
    omp_set_num_threads(3);
    CHECK(predict(net, inputs) == together);
    const std::size_t values = size(net.output_shape());
    for (std::size_t n = 0; n < 19; ++n)
      CHECK(std::ranges::equal(predict(net, std::span(inputs).subspan(n * size(one.shape), size(one.shape))),
                               std::span(together).subspan(n * values, values)));
    for (const float value : together) REQUIRE(std::isfinite(value));
  }
}

TEST_CASE("operations: training has the same bits for any number of threads, dropout included") {
  const Threads kept(omp_get_max_threads());
  register_cube();
  const auto inputs = hashed_values<float>(1, 40 * 60), targets = hashed_values<float>(2, 40 * 2);
  const auto train = [&](int count, std::uint64_t seed) {
    omp_set_num_threads(count);
    Network net(
        {2, 6, 5},
        "conv 4 3x3 pad 1 groups 2; layernorm; gelu; residual { conv 4 3x3 pad 2 dilation 2; tanh; dropout 0.3 }; "
        "maxpool 3 stride 2 pad 1; cube; fc 2");
    net.initialise(1);
    const FitLog log = fit(net, {inputs, targets, 40}, {.epochs = 3, .batch = 20, .validation = 0.2, .seed = seed});
    CHECK(std::isfinite(log.epochs.back().training_loss));
    return weights_sha256(net);
  };
  const std::string one = train(1, 1);
  CHECK(train(2, 1) == one);
  CHECK(train(8, 1) == one);
  CHECK(train(1, 2) != one);
}

TEST_CASE("operations: training has the same bits for any number of processes, dropout included") {
  constexpr int batch = 16 * 5 - 3, steps = 3;
  const auto inputs = hashed_values<float>(1, batch * 60), diffs = hashed_values<float>(2, batch * 2);
  const auto train = [&](int ranks) {
    std::vector<std::string> bits(static_cast<std::size_t>(ranks));
    decid::test::with_ranks(ranks, [&](decid::Communicator& own) {
      Network net({2, 6, 5}, "dropout 0.2; conv 4 3x3 pad 1 groups 2; layernorm; gelu; dropout 0.5; statspool; fc 2");
      net.initialise(1);
      Trainer<float> trainer(net, batch, ranks > 1 ? &own : nullptr);
      const auto optimiser = sgd();
      OptimiserState state = begin(*optimiser, net);
      const std::vector<int> samples = trainer.own_samples(batch);
      for (int step = 0; step < steps; ++step) {
        for (std::size_t i = 0; i < samples.size(); ++i)
          trainer.input().load(static_cast<int>(i),
                               std::span(inputs).subspan(static_cast<std::size_t>(samples[i]) * 60, 60));
        trainer.set_random(9, static_cast<std::uint64_t>(step));
        trainer.forward();
        for (std::size_t i = 0; i < samples.size(); ++i)
          trainer.output_diff().load(static_cast<int>(i),
                                     std::span(diffs).subspan(static_cast<std::size_t>(samples[i]) * 2, 2));
        trainer.backward();
        update(*optimiser, net, trainer.gradients(), 0.01, state);
      }
      bits[static_cast<std::size_t>(own.rank())] = weights_sha256(net);
    });
    for (const std::string& its : bits) CHECK(its == bits.front());
    return bits.front();
  };
  const std::string one = train(1);
  for (const int ranks : {2, 3, 7}) CHECK(train(ranks) == one);
}

TEST_CASE("dropout: drops its rate, scales the rest, another mask each step; inference passes on") {
  Network<float> net({4, 25, 25}, "dropout 0.25");
  Trainer<float> trainer(net, 40);
  const std::vector<float> ones(40 * 2500, 1.0F);
  load_batch(trainer.input(), ones);
  const auto masked = [&](std::uint64_t step) {
    trainer.set_random(1, step);
    trainer.forward();
    return store_batch(trainer.output());
  };
  const std::vector<float> first = masked(0);
  // 100,000 values: a standard deviation of 137. Six of them are exceeded once in 5e8 seeds.
  const auto dropped = std::ranges::count(first, 0.0F);
  CHECK(std::abs(static_cast<double>(dropped) - 25000) < 6 * 137);
  CHECK(std::ranges::count(first, 1 / 0.75F) == 100000 - dropped);
  CHECK(masked(0) == first);
  CHECK(masked(1) != first);
  CHECK(predict(net, ones) == ones);
}

// A channel whose random numbers were another's, begun elsewhere, would have its mask, moved.
TEST_CASE("dropout: no channel's mask is the one before it, moved") {
  Network<float> net({4, 25, 25}, "dropout 0.25");
  Trainer<float> trainer(net, 1);
  load_batch(trainer.input(), std::vector<float>(2500, 1.0F));
  trainer.set_random(1, 0);
  trainer.forward();
  const std::vector<float> masks = store_batch(trainer.output());
  // Independent masks agree in 0.625 of their places: six standard deviations are 0.15 at half of the length.
  for (std::size_t channel = 1; channel < 4; ++channel)
    for (std::size_t moved = 0; moved < 312; ++moved) {
      const auto first = masks.begin() + static_cast<std::ptrdiff_t>(625 * channel);
      const auto before = first - 625 + static_cast<std::ptrdiff_t>(moved);
      int agree = 0;
      for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(625 - moved); ++i)
        agree += (first[i] == 0.0F) == (before[i] == 0.0F) ? 1 : 0;
      CHECK(agree < 0.8 * static_cast<double>(625 - moved));
    }
}

TEST_CASE("architecture: comments, blocks, and what does not fit") {
  const Network net({2, 6, 5},
                    "# a block\n\n conv 4 3x3 pad 1  # same size\r\nresidual { batchnorm;; relu \r\n; conv 4 1x1 }\n"
                    "concat {conv 2 1x1}; fc 3 # ; relu");
  CHECK(net.architecture() ==
        "conv 4 3x3 stride 1x1 pad 1x1\nresidual {\nbatchnorm\nrelu\nconv 4 1x1 stride 1x1 pad 0x0\n}\nconcat {\n"
        "conv 2 1x1 stride 1x1 pad 0x0\n}\nfc 3");
  CHECK(net.layers()[7].dst_shape() == Shape{6, 6, 5});
  for (const char* wrong :
       {"residual { conv 3 1x1 }", "concat { conv 3 3x3 }", "residual { tanh", "tanh; }", "residual tanh"}) {
    CAPTURE(wrong);
    CHECK_THROWS_AS(Network({2, 6, 5}, wrong), decid::Error);
  }
  CHECK(Network({2, 6, 5}, "conv 4 3x3 pad 3 dilation 2").output_shape() == Shape{4, 8, 7});
  register_cube();
  CHECK_NOTHROW(register_cube());
  check_error(
      [&] {
        register_layer("cube", [](Shape src, Words&) -> OperationPointer { return std::make_shared<Cube>(src); });
      },
      decid::Code::setting_conflict);
}

TEST_CASE("register_layer: words of decid's own, no word, no parser, and unusable operations are refused") {
  for (const char* word : {"conv", "fc", "relu", "statspool", "batchnorm", "maxpool", "avgpool", "globalavgpool",
                           "residual", "concat", "{", "}", "tanh", "dropout"})
    check_error([&] { register_layer(word, parse_cube); }, decid::Code::setting_conflict, word);
  for (const char* word : {"", " ", " x y", "x y", "x\n", "#", "x#", "x;y", "x{"})
    check_error([&] { register_layer(word, parse_cube); }, decid::Code::setting_malformed);
  check_error([] { register_layer("nothing", nullptr); }, decid::Code::setting_missing, "nothing");
  // An operation that an architecture cannot use is an error of its line. A text may begin with another layer's word.
  register_cube();
  register_layer("null_layer", [](Shape, Words&) -> OperationPointer { return nullptr; });
  register_layer("turned_layer", [](Shape src, Words&) -> OperationPointer {
    return std::make_shared<Cube>(Shape{src.rows, src.channels, src.columns});
  });
  for (const std::string line : {"null_layer", "turned_layer"})
    check_error([&] { Network({2, 6, 5}, "tanh; " + line); }, decid::Code::setting_malformed, line);
  CHECK_NOTHROW(Network({2, 2, 5}, "tanh; turned_layer"));
}

namespace {

/// With a text of its own.
class Named final : public OperationOf<Named> {
 public:
  Named(Shape shape, std::string text) : OperationOf(shape, shape), text_(std::move(text)) {}
  std::string text() const override { return text_; }
  template <class T>
  void forward_pass(const ForwardPass<T>&) const {}
  template <class T>
  void backward_pass(const BackwardPass<T>&) const {}

 private:
  std::string text_;
};

}  // namespace

// Files have the text, and would not be read.
TEST_CASE("register_layer: an operation whose text does not read back is refused") {
  register_layer("named_well", [](Shape src, Words& words) -> OperationPointer {
    return std::make_shared<Named>(src, "named_well " + std::to_string(words.done() ? 1 : words.take_int(1, 9)));
  });
  CHECK(Network({2, 6, 5}, "named_well").architecture() == "named_well 1");
  CHECK(Network({2, 6, 5}, "named_well 3").architecture() == "named_well 3");
  register_layer("named_other",
                 [](Shape src, Words&) -> OperationPointer { return std::make_shared<Named>(src, "not_registered"); });
  register_layer("named_more",
                 [](Shape src, Words&) -> OperationPointer { return std::make_shared<Named>(src, "named_more 1"); });
  register_layer("named_lines", [](Shape src, Words&) -> OperationPointer {
    return std::make_shared<Named>(src, "named_lines; tanh");
  });
  for (const std::string word : {"named_other", "named_more", "named_lines"})
    check_error([&] { Network({2, 6, 5}, word); }, decid::Code::setting_malformed, "text()");
}
