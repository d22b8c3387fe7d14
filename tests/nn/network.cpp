// Tests of nn/network.hpp: construction, memory plan, initialisation, and trainings whose bits are known.
// Initialisation: He et al., "Delving deep into rectifiers", ICCV 2015; its moments are held to their standard errors.
#include "nn/network.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>
#include <thread>

#include "nn/loss.hpp"
#include "nn/schedule.hpp"
#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

// Counts every allocation of the program; sanitizers have operators of their own.
[[maybe_unused]] static std::atomic<long> allocations{0};
#ifndef DECID_SANITIZED
void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size > 0 ? size : 1)) return p;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto align = static_cast<std::size_t>(alignment);
  if (void* p = std::aligned_alloc(align, (size + align) / align * align)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}
void operator delete(void* p, std::align_val_t) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
  std::free(p);
}
#endif

namespace {

constexpr const char* small =
    "conv 6 3x3 pad 1; batchnorm; relu; maxpool 2; conv 8 3x3 pad 1; batchnorm; relu; avgpool 2; fc 3";
constexpr Shape small_shape{2, 12, 12};
constexpr int small_batch = 24;

void train_step(Network<float>& network, std::span<const float> input, std::span<const float> targets,
                std::span<double> squares, double rate) {
  load_batch(network.input(), input);
  network.forward();
  mean_squared_error(network.output(), targets, squares, &network.output_diff());
  network.backward();
  sgd_step(network, rate, {.momentum = 0.9, .weight_decay = 1e-4});
}

struct Training {
  std::vector<double> losses;
  std::string sha256;
};

/// Learns three of the images' own means, so that there is something to learn.
Training train_small(int steps, std::uint64_t seed = 1) {
  Network<float> network(small_shape, small);
  network.initialise(seed);
  network.plan(small_batch, Mode::training);
  const auto size = static_cast<std::size_t>(small_shape.size());
  std::vector<float> input(size * small_batch), targets(3 * small_batch);
  for (std::size_t n = 0; n < small_batch; ++n) {
    for (std::size_t k = 0; k < 3; ++k) targets[3 * n + k] = static_cast<float>(hashed(1, 3 * n + k));
    for (std::size_t i = 0; i < size; ++i)
      input[n * size + i] = 0.5f * static_cast<float>(hashed(2, n * size + i)) + targets[3 * n + i % 3];
  }
  const Schedule schedule("cosine", 0.05, steps, 10, 3);
  Training training;
  std::vector<double> squares(3);
  for (int step = 0; step < steps; ++step) {
    train_step(network, input, targets, squares, schedule.rate(step));
    training.losses.push_back((squares[0] + squares[1] + squares[2]) / (3 * small_batch));
  }
  training.sha256 = weights_sha256(network);
  return training;
}

std::string network_error(Shape shape, const std::string& architecture) {
  return error_of([&] { const Network<float> network(shape, architecture); });
}

}  // namespace

TEST_CASE("Network: parameters and operations of the reference networks") {
  const Network<float> a({2, 110, 110},
                         "conv 8 3x3 pad 1; batchnorm; relu; avgpool 2; conv 16 3x3 pad 1; batchnorm; relu; avgpool 2; "
                         "conv 32 3x3 pad 1; batchnorm; relu; conv 32 3x3 pad 1; batchnorm; relu; fc 7");
  // 2*8*9+8+16, 8*16*9+16+32, 16*32*9+32+64, 32*32*9+32+64, 27*27*32*7+7
  CHECK(a.parameter_count() == 168 + 1200 + 4704 + 9312 + 163303);
  CHECK(a.parameter_count() == 178687);
  CHECK(a.output_shape() == Shape{7, 1, 1});
  // Multiply-adds of the convolutions and fc; BatchNorm a multiply-add and ReLU one operation a value; pooling a
  // window's.
  const long long plane1 = 110 * 110, plane2 = 55 * 55, plane3 = 27 * 27;
  CHECK(a.flops() == 2 * plane1 * 8 * 18 + 3 * plane1 * 8 + plane2 * 8 * 4 + 2 * plane2 * 16 * 72 + 3 * plane2 * 16 +
                         plane3 * 16 * 4 + 2 * plane3 * 32 * 144 + 3 * plane3 * 32 + 2 * plane3 * 32 * 288 +
                         3 * plane3 * 32 + 2 * plane3 * 32 * 7);

  const Network<float> b(
      {2, 110, 110},
      "conv 64 3x3 pad 1; batchnorm; relu; maxpool 2; conv 64 3x3 pad 1; batchnorm; relu; maxpool 2; "
      "conv 128 3x3 pad 1; batchnorm; relu; maxpool 2; conv 128 3x3 pad 1; batchnorm; relu; "
      "globalavgpool; fc 7");
  CHECK(b.parameter_count() == 261255);
  const long long plane4 = 13 * 13;
  CHECK(b.flops() == 2 * plane1 * 64 * 18 + 3 * plane1 * 64 + plane2 * 64 * 4 + 2 * plane2 * 64 * 576 +
                         3 * plane2 * 64 + plane3 * 64 * 4 + 2 * plane3 * 128 * 576 + 3 * plane3 * 128 +
                         plane4 * 128 * 4 + 2 * plane4 * 128 * 1152 + 3 * plane4 * 128 + plane4 * 128 + 2 * 128 * 7);
}

TEST_CASE("Network: the architecture's text") {
  const Network<float> network({2, 8, 8}, "\n conv 4 3x3 pad 1;;relu \r\n; maxpool 2\n\nfc 3;");
  const std::string complete = "conv 4 3x3 stride 1x1 pad 1x1\nrelu\nmaxpool 2x2 stride 2x2\nfc 3";
  CHECK(network.architecture() == complete);
  CHECK(Network<double>({2, 8, 8}, complete).architecture() == complete);
  CHECK(network.input_shape() == Shape{2, 8, 8});
  REQUIRE(network.layers().size() == 4);
  CHECK(network.layers()[3]->src_shape() == Shape{4, 4, 4});
}

TEST_CASE("Network: construction errors") {
  for (const Shape shape : {Shape{0, 4, 4}, Shape{1, 0, 4}, Shape{1, 4, -1}})
    CHECK(network_error(shape, "fc 3") == "network input: has no values");
  CHECK(network_error({65536, 65536, 65536}, "fc 3") == "network input: has more than 268435456 values a sample");
  for (const char* text : {"", " ;\n; ", "relu", "relu; fc 3"})
    CHECK(network_error({1, 4, 4}, text) == "network architecture: does not begin with a layer that computes");
  CHECK(network_error({1, 4, 4}, "fc 3; maxpool 2") == "layer ' maxpool 2': has a window larger than its input of 1x1");
  CHECK(network_error({1, 4, 4}, "fc 3\nconv") == "layer 'conv': ends where another word is expected");
}

TEST_CASE("Network: plan, batch and mode errors") {
  Network<float> network(small_shape, small);
  CHECK(error_of([&] { network.forward(); }) == "network: has no memory yet");
  CHECK(error_of([&] { network.set_batch(1); }) == "batch: of 1 samples where 0 were planned");
  for (const int batch : {0, -1, 65537})
    CHECK(error_of([&] { network.plan(batch, Mode::training); }) == "batch: of " + std::to_string(batch) + " samples");
  network.plan(20, Mode::inference);
  CHECK(network.planned_batch() == 20);
  CHECK(error_of([&] { network.backward(); }) == "network: was planned for inference");
  for (const int batch : {0, -3, 21})
    CHECK(error_of([&] { network.set_batch(batch); }) ==
          "batch: of " + std::to_string(batch) + " samples where 20 were planned");
  network.set_batch(20);
  network.set_batch(1);
  CHECK(network.output().batch() == 1);
  const std::size_t inference_bytes = network.planned_bytes();
  network.plan(20, Mode::training);
  CHECK(network.planned_bytes() > inference_bytes);
  CHECK(error_of([&] { network.backward(); }) == "none");
}

TEST_CASE("Network: He's initialisation") {
  Network<float> network({2, 20, 20}, "conv 32 5x5; batchnorm; conv 32 3x3; fc 40");
  network.initialise(42);
  for (const Parameter<float>* p : network.parameters()) {
    CAPTURE(p->name);
    if (p->name != "weight") {
      for (const float v : p->value) CHECK(v == (p->name == "gamma" ? 1.0f : 0.0f));
      continue;
    }
    const auto count = static_cast<double>(p->value.size());
    REQUIRE(p->fan_in == static_cast<int>(count) / p->shape[0]);
    double sum = 0, squares = 0, fourth = 0;
    for (const float v : p->value) {
      const double z = static_cast<double>(v) * std::sqrt(p->fan_in / 2.0);  // standard normal
      sum += z;
      squares += z * z;
      fourth += z * z * z * z;
    }
    CHECK(std::abs(sum / count) < 4 * std::sqrt(1 / count));
    CHECK(std::abs(squares / count - 1) < 4 * std::sqrt(2 / count));
    CHECK(std::abs(fourth / count - 3) < 4 * std::sqrt(96 / count));
  }
  const std::string sha256 = weights_sha256(network);
  Network<float> other({2, 20, 20}, network.architecture());
  other.initialise(42);
  CHECK(weights_sha256(other) == sha256);
  other.initialise(43);
  CHECK(weights_sha256(other) != sha256);
  // Tensors have numbers of their own, and a precision rounds the same ones.
  CHECK(network.parameters()[0]->value[0] / network.parameters()[4]->value[0] !=
        doctest::Approx(std::sqrt(288.0 / 50.0)));
  Network<double> precise({2, 20, 20}, network.architecture());
  precise.initialise(42);
  CHECK(static_cast<float>(precise.parameters()[4]->value[7]) == network.parameters()[4]->value[7]);
}

TEST_CASE("Network: initialise() forgets a training, its momentum and its running statistics") {
  Network<float> network(small_shape, small);
  network.initialise(7);
  const std::string fresh = weights_sha256(network);
  network.plan(4, Mode::training);
  const auto input = hashed_values<float>(1, 4 * 288), targets = hashed_values<float>(2, 12);
  std::vector<double> squares(3);
  train_step(network, input, targets, squares, 0.1);
  const std::string once = weights_sha256(network);
  CHECK(once != fresh);
  train_step(network, input, targets, squares, 0.1);
  network.initialise(7);
  CHECK(weights_sha256(network) == fresh);
  train_step(network, input, targets, squares, 0.1);
  CHECK(weights_sha256(network) == once);
}

TEST_CASE("weights_sha256: every value, name and shape counts") {
  Network<float> network({1, 4, 4}, "conv 2 3x1; batchnorm; fc 2");
  network.initialise(1);
  const std::string sha256 = weights_sha256(network);
  CHECK(sha256.size() == 64);
  const auto changes = [&](std::vector<float>& values) {
    for (float& v : values) {
      const float kept = v;
      v = std::nextafter(v, 10.0f);
      CHECK(weights_sha256(network) != sha256);
      v = kept;
    }
  };
  for (Parameter<float>* p : network.parameters()) changes(p->value);
  for (const auto& layer : network.layers())
    for (Statistic<float>* s : layer->statistics()) changes(s->value);
  CHECK(weights_sha256(network) == sha256);
  const Network<float> tall({1, 4, 4}, "conv 2 3x1"), wide({1, 4, 4}, "conv 2 1x3");
  CHECK(weights_sha256(tall) != weights_sha256(wide));
}

TEST_CASE("sgd_step: by hand") {
  Network<float> network({1, 1, 1}, "fc 1");
  Parameter<float>&weight = *network.parameters()[0], &bias = *network.parameters()[1];
  weight.value = {2};
  bias.value = {2};
  weight.gradient = bias.gradient = {1};
  weight.velocity = bias.velocity = {4};
  sgd_step(network, 0.5, {.momentum = 0.25, .weight_decay = 0.125});
  CHECK(weight.velocity[0] == 2.25f);  // 0.25 * 4 + (1 + 0.125 * 2)
  CHECK(weight.value[0] == 0.875f);
  CHECK(bias.velocity[0] == 2.0f);  // no decay
  CHECK(bias.value[0] == 1.0f);
  CHECK(weight.gradient[0] == 1.0f);
}

TEST_CASE("training: the loss falls, and threads have no say in the bits") {
  const int threads = omp_get_max_threads();
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
  omp_set_num_threads(threads);
}

TEST_CASE("training: threads that came after plan() have their memory too") {
  kernels<float>();  // an instruction set that cannot run throws here, not in the thread below
  const int threads = omp_get_max_threads();
  const auto input = hashed_values<float>(1, small_batch * 288), targets = hashed_values<float>(2, small_batch * 3);
  std::vector<double> squares(3);
  std::string expected;
  for (const int count : {1, 2, 8}) {
    CAPTURE(count);
    omp_set_num_threads(1);
    Network<float> network(small_shape, small);
    network.initialise(1);
    network.plan(small_batch, Mode::training);
    omp_set_num_threads(count);
    // A thread of its own, with a team of its own.
    std::thread([&] {
      omp_set_num_threads(count);
      train_step(network, input, targets, squares, 0.1);
    }).join();
    train_step(network, input, targets, squares, 0.1);
    if (count == 1) expected = weights_sha256(network);
    CHECK(weights_sha256(network) == expected);
  }
  omp_set_num_threads(threads);
}

// The same on every instruction set, compiler and number of threads (kernels.hpp). A change of this figure changes what
// every model trains to, and is a new version of the program.
TEST_CASE("training: pinned bits of 50 steps from seed 1") {
  CHECK(train_small(50).sha256 == "531d03fff66e4df54207e485c5495f27f511e7e607a2f00674e6cf666af1f30c");
}

TEST_CASE("training: a step allocates nothing") {
#ifdef DECID_SANITIZED
  MESSAGE("a sanitizer owns operator new: not counted");
#else
  Network<float> network(small_shape, small);
  network.initialise(1);
  network.plan(small_batch, Mode::training);
  const auto input = hashed_values<float>(1, small_batch * 288), targets = hashed_values<float>(2, small_batch * 3);
  std::vector<double> squares(3);
  train_step(network, input, targets, squares, 0.1);  // threads start, kernels are chosen
  const long before = allocations;
  for (const int batch : {small_batch, 17, 1}) {
    network.set_batch(batch);
    train_step(network, input, targets, squares, 0.1);
  }
  const long in_training = allocations - before;
  CHECK(in_training == 0);
  network.plan(small_batch, Mode::inference);
  network.forward();
  const long before_inference = allocations;
  network.set_batch(5);
  network.forward();
  const long in_inference = allocations - before_inference;
  CHECK(in_inference == 0);
  CHECK(before > 0);  // the counter counts
#endif
}

TEST_CASE("a layer's output in inference is that of a network that ends there") {
  constexpr int batch = 20;  // sample 17 lies in the second block of lanes
  Network<float> network(small_shape, small), start(small_shape, "conv 6 3x3 pad 1; batchnorm");
  network.initialise(4);
  start.initialise(4);
  for (Network<float>* n : {&network, &start}) {
    std::vector<Statistic<float>*> running = n->layers().at(1)->statistics();
    for (auto* s : running)
      for (std::size_t i = 0; i < s->value.size(); ++i) s->value[i] = 0.3F + static_cast<float>(i) / 5.0F;
    n->plan(batch, Mode::inference);
  }
  const auto values = static_cast<std::size_t>(small_shape.size());
  for (int sample = 0; sample < batch; ++sample) {
    const auto image = hashed_values<float>(static_cast<std::uint32_t>(sample), values);
    network.input().load(sample, image);
    start.input().load(sample, image);
  }
  start.forward();
  const auto first = static_cast<std::size_t>(start.output_shape().size());
  REQUIRE(network.layers().at(0)->dst_shape() == start.output_shape());
  std::vector<float> seen(first), wanted(first);
  for (const int sample : {0, 15, 17}) {
    network.activation(0, sample, seen);
    start.output().store(sample, wanted);
    CAPTURE(sample);
    CHECK(seen == wanted);
  }
  network.forward();
  std::vector<float> output(3), last(3);
  network.output().store(17, output);
  network.activation(network.layers().size() - 1, 17, last);
  CHECK(last == output);

  CHECK_THROWS_AS(network.activation(network.layers().size(), 0, last), decid::Error);
  CHECK_THROWS_AS(network.activation(0, batch, seen), decid::Error);
  CHECK_THROWS_AS(network.activation(0, 0, last), decid::Error);
  network.plan(batch, Mode::training);
  CHECK_THROWS_AS(network.activation(0, 0, seen), decid::Error);
}
