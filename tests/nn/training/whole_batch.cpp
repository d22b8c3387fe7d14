// Tests of losses and samples that see a batch at once, and of optimisers that see a whole parameter: the bits of the
// ones that see one at a time, calls from fit()'s own thread, and exceptions in each.
#include <doctest/doctest.h>
#include <omp.h>

#include <cmath>
#include <thread>

#include "nn/fit.hpp"
#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

namespace {

constexpr int count = 60, classes = 3;
constexpr Shape shape{1, 6, 6};
constexpr const char* text = "conv 4 3x3 pad 1; batchnorm; relu; maxpool 2; fc 3";

/// Writes sample `sample`: noise, brighter with each class, and more noise in training.
void make(int sample, const decid::Random* random, std::span<float> input, std::span<float> target) {
  for (std::size_t i = 0; i < input.size(); ++i) {
    input[i] = static_cast<float>(hashed(static_cast<std::uint32_t>(sample), i) + sample % classes);
    if (random != nullptr) input[i] += 0.1F * static_cast<float>(random->normal(i));
  }
  for (std::size_t i = 0; i < target.size(); ++i) target[i] = i == static_cast<std::size_t>(sample % classes) ? 1 : 0;
}

FitOptions options() {
  FitOptions o;
  o.epochs = 2;
  o.batch = 20;
  o.learning_rate = 0.01;
  return o;
}

std::string fitted(const FitOptions& o, const Samples& samples = {count, make}) {
  Network<float> network(shape, text);
  fit(network, samples, o);
  return weights_sha256(network);
}

/// The squared error of a batch.
class BatchError final : public BatchLoss {
 public:
  void batch(std::span<const double> outputs, std::span<const double> targets, std::span<double> losses,
             std::span<double> diffs) const override {
    CHECK(std::this_thread::get_id() == thread_);
    const auto samples = static_cast<double>(losses.size());
    const std::size_t width = outputs.size() / losses.size();
    std::ranges::fill(losses, 0.0);
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const double error = outputs[i] - targets[i];
      losses[i / width] += error * error;
      diffs[i] = 2 * error / static_cast<double>(width) / samples;
    }
    for (double& loss : losses) loss /= static_cast<double>(width);
    if (++calls == fails_at) throw std::runtime_error("loss");
  }
  std::string text() const override { return "batch-error"; }

  int fails_at = 0;
  mutable int calls = 0;

 private:
  std::thread::id thread_ = std::this_thread::get_id();
};

/// Descent by the gradient's sign, which needs no other value.
class SignDescent final : public Optimiser {
 public:
  explicit SignDescent(bool whole) : whole_(whole) {}
  void update(const Values& v, double learning_rate, long long step) const override {
    if (whole_) {
      CHECK(std::this_thread::get_id() == thread_);
      std::size_t values = 1;
      for (const int extent : v.shape) values *= static_cast<std::size_t>(extent);
      CHECK(values == v.count);
      if (step == fails_at) throw std::runtime_error("optimiser");
    }
    for (std::size_t i = 0; i < v.count; ++i) {
      v.memory[0][i] += v.gradient[i];
      v.value[i] -= static_cast<float>(v.memory[0][i] > 0 ? learning_rate : -learning_rate);
    }
  }
  bool whole_parameters() const override { return whole_; }
  int memory() const override { return 1; }
  std::string text() const override { return "sign-descent"; }

  long long fails_at = 0;

 private:
  bool whole_;
  std::thread::id thread_ = std::this_thread::get_id();
};

}  // namespace

TEST_CASE("fit: a loss of batches, samples written together and an optimiser of parameters keep the bits") {
  FitOptions one = options();
  one.optimiser = std::make_shared<SignDescent>(false);
  std::vector<int> epochs;
  const Samples together(count, [&](const Samples::Batch& batch) {
    const std::size_t width = batch.targets.size() / batch.samples.size();
    const auto values = static_cast<std::size_t>(shape.size());
    if (!batch.random.empty()) {
      CHECK(batch.random.size() == batch.samples.size());
      epochs.push_back(batch.epoch);
    }
    for (std::size_t i = 0; i < batch.samples.size(); ++i)
      make(batch.samples[i], batch.random.empty() ? nullptr : &batch.random[i],
           batch.inputs.subspan(i * values, values), batch.targets.subspan(i * width, width));
  });
  for (const int number : {1, 3}) {
    CAPTURE(number);
    const Threads threads(number);
    const std::string expected = fitted(one);
    FitOptions o = one;
    o.loss = std::make_shared<BatchError>();
    CHECK(fitted(o) == expected);
    epochs.clear();
    CHECK(fitted(o, together) == expected);
    CHECK(epochs == std::vector<int>{1, 1, 1, 2, 2, 2});  // of 54 samples in 3 batches
    o.optimiser = std::make_shared<SignDescent>(true);
    CHECK(fitted(o, together) == expected);
    // Alone, outside of a fit.
    Network<float> network(shape, text);
    network.initialise(1);
    CHECK(mean_loss(network, together, *o.loss) == mean_loss(network, {count, make}, *squared_error()));
    std::vector<float> input(36), target(3), same_input(36), same_target(3);
    make(7, nullptr, input, target);
    together.load()(7, nullptr, same_input, same_target);
    CHECK(same_input == input);
    CHECK(same_target == target);
  }
  CHECK_THROWS_AS(Samples(count, Samples::LoadBatch()), decid::Error);
}

TEST_CASE("fit: an exception in a loss, samples or an optimiser arrives, and leaves the weights of the last step") {
  const Threads threads(3);
  // 3 steps an epoch, of which 4 are done; the loss is also called to validate.
  const auto failing = [](int where, Network<float>& network) {
    FitOptions o = options();
    o.average = 0.5;
    const auto loss = std::make_shared<BatchError>();
    const auto optimiser = std::make_shared<SignDescent>(true);
    if (where == 0) loss->fails_at = 6;
    if (where == 1) optimiser->fails_at = 5;
    int loads = 0;
    o.loss = loss;
    o.optimiser = optimiser;
    const Samples samples(count, [&](const Samples::Batch& batch) {
      for (std::size_t i = 0; i < batch.samples.size(); ++i)
        make(batch.samples[i], batch.random.empty() ? nullptr : &batch.random[i], batch.inputs.subspan(i * 36, 36),
             batch.targets.subspan(i * 3, 3));
      if (where == 2 && ++loads == 6) throw std::runtime_error("samples");
    });
    if (where == 3)
      o.after_batch = [](int epoch, int batch, double) {
        if (epoch == 2 && batch == 1) throw std::runtime_error("callback");
        return true;
      };
    CHECK_THROWS_AS(fit(network, samples, o), std::runtime_error);
  };
  Network<float> expected(shape, text);
  failing(3, expected);
  for (int where = 0; where < 3; ++where) {
    CAPTURE(where);
    Network<float> network(shape, text);
    failing(where, network);
    for (std::size_t k = 0; k < network.parameters().size(); ++k)
      CHECK(network.parameters()[k]->value == expected.parameters()[k]->value);
    CHECK_NOTHROW(fit(network, {count, make}, options()));
  }
}
