// Tests of nn/training/trainer.hpp: errors, trainings whose bits are known, and that a training leaves nothing in a
// network but weights and statistics.
#include "nn/training/trainer.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <numeric>
#include <thread>
#include <utility>

#include "base/error.hpp"
#include "nn/predictor.hpp"
#include "nn/training/loss.hpp"
#include "nn/training/optimiser.hpp"
#include "nn/training/schedule.hpp"
#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

// Counts every allocation of the program, and refuses large ones; sanitizers have operators of their own. Not inlined:
// g++ 12 would take malloc() or free() in the place of one for a mistake.
[[maybe_unused]] static std::atomic<long> allocations{0};
[[maybe_unused]] static std::atomic<std::size_t> max_bytes{~std::size_t{0}};
#ifndef DECID_SANITIZED
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = size > max_bytes ? nullptr : std::malloc(size > 0 ? size : 1)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto align = static_cast<std::size_t>(alignment);
  if (void* p = size > max_bytes ? nullptr : std::aligned_alloc(align, (size + align) / align * align)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::align_val_t) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
  std::free(p);
}
#endif

namespace {

constexpr const char* small =
    "conv 6 3x3 pad 1; batchnorm; relu; maxpool 2; conv 8 3x3 pad 1; batchnorm; relu; avgpool 2; fc 3";
constexpr Shape small_shape{2, 12, 12};
constexpr int small_batch = 24;

/// A network in training by sgd().
struct InTraining {
  InTraining(Network<float>& trained, int batch)
      : network(trained), trainer(trained, batch), optimiser(sgd()), state(begin(*optimiser, network)) {}
  /// Computes the gradients; returns the mean squared error.
  double pass(std::span<const float> input, std::span<const float> targets) {
    const int batch = trainer.output().batch();
    parts.resize(3 * TensorView<float>::count_blocks(batch));
    load_batch(trainer.input(), input);
    trainer.forward();
    squared_errors(trainer.output(), targets, batch, parts, trainer.output_diff());
    trainer.backward();
    return std::accumulate(parts.begin(), parts.end(), 0.0) / (3 * batch);
  }
  double step(std::span<const float> input, std::span<const float> targets, double rate = 0.1) {
    const double loss = pass(input, targets);
    update(*optimiser, network, trainer.gradients(), rate, state);
    return loss;
  }

  Network<float>& network;
  Trainer<float> trainer;
  std::shared_ptr<const Optimiser> optimiser;
  OptimiserState state;
  std::vector<double> parts;  // of squared_errors()
};

struct Training {
  std::vector<double> losses;
  std::string sha256;
};

/// Learns three of the images' own means, so that there is something to learn.
Training train_small(int steps, std::uint64_t seed = 1) {
  Network<float> network(small_shape, small);
  network.initialise(seed);
  InTraining trained(network, small_batch);
  const auto size = static_cast<std::size_t>(small_shape.size());
  std::vector<float> input(size * small_batch), targets(3 * small_batch);
  for (std::size_t n = 0; n < small_batch; ++n) {
    for (std::size_t k = 0; k < 3; ++k) targets[3 * n + k] = static_cast<float>(hashed(1, 3 * n + k));
    for (std::size_t i = 0; i < size; ++i)
      input[n * size + i] = 0.5f * static_cast<float>(hashed(2, n * size + i)) + targets[3 * n + i % 3];
  }
  const Schedule schedule("cosine", 0.05, steps, 10, 3);
  Training training;
  for (int step = 0; step < steps; ++step) training.losses.push_back(trained.step(input, targets, schedule.rate(step)));
  training.sha256 = weights_sha256(network);
  return training;
}

}  // namespace

TEST_CASE("Trainer: batch errors") {
  Network<float> network(small_shape, small);
  for (const int batch : {0, -1, 65537})
    check_error([&] { Trainer<float>(network, batch); }, decid::Code::setting_out_of_range, std::to_string(batch));
  Trainer<float> trainer(network, 20);
  CHECK(trainer.max_batch() == 20);
  for (const int batch : {0, -3, 21})
    check_error([&] { trainer.set_batch(batch); }, decid::Code::setting_out_of_range, std::to_string(batch));
  trainer.set_batch(20);
  trainer.set_batch(1);
  CHECK(trainer.output().batch() == 1);
  const Predictor predictor(network, 20);
  CHECK(trainer.memory_bytes() > predictor.memory_bytes());
}

TEST_CASE("Trainer: a batch in which a BatchNorm has one value a channel is refused, by the layer's name") {
  Network<float> lone({1, 4, 4}, "conv 3 3x3; batchnorm; relu; fc 5; batchnorm; relu; fc 2");
  const auto refused = [](const auto& call, const char* layer) {
    check_error(call, decid::Code::setting_out_of_range, layer);
  };
  refused([&] { Trainer<float>(lone, 1); }, "layers.4, batchnorm");
  Trainer<float> trainer(lone, 2);
  refused([&] { trainer.set_batch(1); }, "layers.4, batchnorm");
  trainer.set_batch(2);
  Network<float> first({3, 1, 1}, "batchnorm; fc 2"), wide({3, 1, 2}, "batchnorm; fc 2"), without({3, 1, 1}, "fc 2");
  refused([&] { Trainer<float>(first, 1); }, "layers.0, batchnorm");
  CHECK_NOTHROW(Trainer<float>(wide, 1));
  CHECK_NOTHROW(Trainer<float>(without, 1));
}

TEST_CASE("Trainer: gradients are those of its parameters") {
  Network<float> network({2, 1, 1}, "fc 3");
  Trainer<float> trainer(network, 4);
  CHECK(trainer.gradient(0).size() == 6);
  CHECK(trainer.gradient(1).size() == 3);
  check_error([&] { trainer.gradient(2); }, decid::Code::setting_out_of_range, "2 of 2");
  CHECK_THROWS_AS(std::as_const(trainer).gradient(99), decid::Error);
}

TEST_CASE("squared_errors: sizes that do not match") {
  Network<float> network({2, 1, 1}, "fc 3");
  Trainer<float> trainer(network, 4);
  const auto loss = [&](std::size_t targets, std::size_t sums) {
    return [&trainer, targets, sums] {
      std::vector<double> parts(sums);
      squared_errors(trainer.output(), std::vector<float>(targets), 4, parts, trainer.output_diff());
    };
  };
  CHECK_NOTHROW(loss(12, 3)());
  CHECK_NOTHROW(loss(16, 3)());  // of a larger batch
  for (const auto& [targets, sums] : {std::pair<std::size_t, std::size_t>{11, 3}, {0, 3}, {12, 2}})
    check_error(loss(targets, sums), decid::Code::size_mismatch, "batch of 4");
  const std::vector<float> targets(12);
  std::vector<double> parts(3);
  check_error([&] { squared_errors(trainer.output(), targets, 4, parts, trainer.input()); },
              decid::Code::size_mismatch);
}

TEST_CASE("training: initialise() forgets the running statistics, and another state goes on to the bit") {
  Network<float> network(small_shape, small);
  network.initialise(7);
  const std::string fresh = weights_sha256(network);
  const auto input = hashed_values<float>(1, 4 * 288), targets = hashed_values<float>(2, 12);
  InTraining training(network, 4);
  training.step(input, targets);
  const std::string once = weights_sha256(network);
  CHECK(once != fresh);
  Network<float> resumed = network, forgetful = network;
  InTraining other(resumed, 4);
  other.state = training.state;
  for (InTraining* t : {&training, &other}) t->step(input, targets);
  InTraining(forgetful, 4).step(input, targets);
  CHECK(weights_sha256(resumed) == weights_sha256(network));
  CHECK(weights_sha256(forgetful) != weights_sha256(network));
  network.initialise(7);
  CHECK(weights_sha256(network) == fresh);
  InTraining(network, 4).step(input, targets);
  CHECK(weights_sha256(network) == once);
}

TEST_CASE("training: leaves nothing in the network but weights and statistics") {
  Network<float> trained(small_shape, small);
  trained.initialise(7);
  const auto input = hashed_values<float>(1, 4 * 288), targets = hashed_values<float>(2, 12);
  {
    InTraining training(trained, 4);
    for (int step = 0; step < 3; ++step) training.step(input, targets);
  }
  // A network that never was in training, with the same weights and statistics, does all that follows alike.
  Network<float> written(small_shape, small);
  for (std::size_t k = 0; k < written.parameters().size(); ++k)
    written.parameters()[k]->value = trained.parameters()[k]->value;
  for (std::size_t i = 0; i < written.layers().size(); ++i)
    for (std::size_t k = 0; k < written.layers()[i].statistics().size(); ++k)
      written.layers()[i].statistics()[k].value = trained.layers()[i].statistics()[k].value;
  std::vector<std::vector<float>> outputs;
  for (Network<float>* network : {&trained, &written}) {
    outputs.emplace_back(12);
    Predictor(*network, 4).run(input, outputs.back());
    InTraining(*network, 4).step(input, targets);
  }
  CHECK(outputs[0] == outputs[1]);
  CHECK(weights_sha256(trained) == weights_sha256(written));
  // All that the type holds is its shape and its layers, and all that these hold is what they are.
  static_assert(sizeof(Network<float>) <= sizeof(Shape) + sizeof(std::vector<Layer<float>>) + sizeof(void*));
  static_assert(sizeof(Layer<float>) <= sizeof(LayerKind) + 2 * sizeof(std::vector<float>) + sizeof(void*));
}

TEST_CASE("training: the loss falls, and threads have no say in the bits") {
  const Threads kept(omp_get_max_threads());
  omp_set_num_threads(1);
  const Training one = train_small(20);
  CHECK(one.losses.back() < 0.5 * one.losses.front());
  CHECK(one.losses.back() < one.losses[10]);
  CHECK(train_small(20, 2).sha256 != one.sha256);
  for (const int count : {2, 3, 8}) {
    CAPTURE(count);
    omp_set_num_threads(count);
    const Training training = train_small(20);
    CHECK(training.sha256 == one.sha256);
    CHECK(training.losses == one.losses);
  }
}

#if !defined(__wasm__)  // a page has one thread
TEST_CASE("training: threads that came after the trainer have their memory too") {
  kernels<float>();  // an instruction set that cannot run throws here, not in the thread below
  const Threads kept(omp_get_max_threads());
  const auto input = hashed_values<float>(1, small_batch * 288), targets = hashed_values<float>(2, small_batch * 3);
  std::string expected;
  for (const int count : {1, 2, 8}) {
    CAPTURE(count);
    omp_set_num_threads(1);
    Network<float> network(small_shape, small);
    network.initialise(1);
    InTraining training(network, small_batch);
    omp_set_num_threads(count);
    // A thread of its own, with a team of its own.
    std::thread([&] {
      omp_set_num_threads(count);
      training.step(input, targets);
    }).join();
    training.step(input, targets);
    if (count == 1) expected = weights_sha256(network);
    CHECK(weights_sha256(network) == expected);
  }
}
#endif

// The same on every instruction set, compiler and number of threads (kernels.hpp). A change of this figure changes what
// every model trains to, and is a new version of the program.
TEST_CASE("training: pinned bits of 50 steps from seed 1") {
  CHECK(train_small(50).sha256 == "531d03fff66e4df54207e485c5495f27f511e7e607a2f00674e6cf666af1f30c");
}

TEST_CASE("training: BatchNorm has scratch only with a pool, and reports that there is no memory for it") {
#ifdef DECID_SANITIZED
  MESSAGE("a sanitizer owns operator new: nothing is refused");
#else
  const auto is_made = [](Shape shape, const std::vector<std::string>& lines) {
    std::vector<Layer<float>> layers = make_layers<float>(shape, lines);
    max_bytes = 1U << 18U;
    bool made = true;
    try {
      make_training_layer<float>(layers.front(), 1);
    } catch (const std::bad_alloc&) {
      made = false;
    }
    max_bytes = ~std::size_t{0};
    return made;
  };
  CHECK(is_made({1, 1, 4096}, {"batchnorm"}));                          // bands of 1 MB
  CHECK_FALSE(is_made({1, 4096, 64}, {"batchnorm", "globalavgpool"}));  // one of 16 MB
#endif
}

TEST_CASE("training: forward and backward allocate nothing") {
#ifdef DECID_SANITIZED
  MESSAGE("a sanitizer owns operator new: not counted");
#else
  Network<float> network(small_shape, small);
  network.initialise(1);
  InTraining training(network, small_batch);
  const auto input = hashed_values<float>(1, small_batch * 288), targets = hashed_values<float>(2, small_batch * 3);
  training.pass(input, targets);  // threads start, kernels are chosen
  const long before = allocations;
  for (const int batch : {small_batch, 17, 1}) {
    training.trainer.set_batch(batch);
    training.pass(input, targets);
  }
  const long in_training = allocations - before;
  CHECK(in_training == 0);
  Predictor predictor(network, small_batch);
  std::vector<float> outputs(small_batch * 3),
      features(small_batch * static_cast<std::size_t>(predictor.feature_count()));
  predictor.run(input, outputs, features);
  const long before_inference = allocations;
  predictor.run(input, outputs, features);
  predictor.run(std::span(input).first(5 * 288), std::span(outputs).first(5 * 3));
  const long in_inference = allocations - before_inference;
  CHECK(in_inference == 0);
  CHECK(before > 0);  // the counter counts
#endif
}
