// Tests of nn/fit.hpp: what samples, checkpoints and networks are refused, and what errors name.
#include <doctest/doctest.h>
#include <omp.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <stdexcept>

#include "base/files/file.hpp"
#include "nn/fit.hpp"
#include "nn/network_file.hpp"
#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;
using decid::Code;

namespace {

constexpr int count = 40;
constexpr Shape shape{3, 1, 1};

const std::vector<float>& inputs() {
  static const auto values = hashed_values<float>(1, 3 * count);
  return values;
}
const std::vector<float>& targets() {
  static const auto values = hashed_values<float>(2, 2 * count);
  return values;
}
Samples samples() {
  return {inputs(), targets(), count};
}
FitOptions options() {
  FitOptions o;
  o.epochs = 2;
  o.batch = 8;
  return o;
}

Network<float> initialised(const char* architecture, Shape input = shape) {
  Network<float> network(input, architecture);
  network.initialise(1);
  return network;
}

/// A file's path, which the destructor removes.
struct Scratch {
  explicit Scratch(const std::string& name)
      : path((std::filesystem::temp_directory_path() / ("decid_fit_samples_" + name)).string()) {
    std::filesystem::remove(path);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() { std::filesystem::remove(path); }
  std::string path;
};

}  // namespace

// Its weights are the last step's, not those that the fit keeps.
TEST_CASE("fit: the checkpoint of a fit is not read as a network") {
  const Scratch file("checkpoint");
  FitOptions o = options();
  o.average = 0.9;
  o.checkpoint = file.path;
  Network<float> network(shape, "fc 4; relu; fc 2");
  fit(network, samples(), o);
  check_error([&] { read_network(file.path); }, Code::file_unsupported, "checkpoint");
  Network<float> again(shape, "fc 4; relu; fc 2");
  fit(again, samples(), o);  // fit() itself reads it
  CHECK(weights_sha256(again) == weights_sha256(network));
}

TEST_CASE("fit: a zero layer whose zeros a relu reads is refused, another one trains") {
  const auto trains = [](Network<float> network, int frozen_lines = 0) {
    const std::string before = weights_sha256(network);
    FitOptions o = options();
    o.frozen_lines = frozen_lines;
    fit(network, samples(), o);
    return weights_sha256(network) != before;
  };
  const auto without = [](const char* architecture, std::size_t layer) {
    Network<float> network = initialised(architecture);
    for (Parameter<float>& p : network.layers()[layer].parameters()) std::ranges::fill(p.value, 0.0F);
    return network;
  };
  for (const char* architecture :
       {"fc 4; relu; fc 2", "fc 4; batchnorm; relu; fc 2", "fc 4; dropout 0.1; tanh; relu; fc 2",
        "fc 4; fc 3; relu; fc 2", "fc 4; layernorm; relu; fc 2", "fc 4; maxpool 1; relu; fc 2",
        "conv 4 1 groups 1 dilation 2; relu; fc 2"})
    check_error([&] { trains(without(architecture, 0)); }, Code::setting_missing, "line 1,");
  check_error([&] { trains(without("fc 4; residual { fc 4; relu }; fc 2", 2)); }, Code::setting_missing, "line 3,");
  for (const char* architecture : {"fc 4; tanh; fc 2", "fc 4; sigmoid; relu; fc 2", "fc 4; fc 2",
                                   "fc 4; leakyrelu; fc 2", "fc 4; residual { fc 4; relu }; fc 2"})
    CHECK(trains(without(architecture, 0)));
  // Biases of the layers behind, and beta, are above 0 somewhere: the relu passes gradients there.
  for (const auto& [architecture, layer] : {std::pair{"fc 4; fc 3; relu; fc 2", 1},
                                            {"fc 4; batchnorm; relu; fc 2", 1},
                                            {"fc 4; layernorm; relu; fc 2", 1}}) {
    Network<float> network = without(architecture, 0);
    std::ranges::fill(network.layers()[static_cast<std::size_t>(layer)].parameters()[1].value, 0.5F);
    CHECK(trains(network));
  }
  CHECK(trains(without("fc 4; relu; fc 2", 0), 1));  // it is not to be trained
}

// A value that a function does not write would be another sample's.
TEST_CASE("fit: values that a function of samples does not write are refused") {
  FitOptions o = options();
  for (const bool of_input : {true, false})
    for (const bool in_training : {true, false}) {
      const Samples partly(
          count, [&](int sample, const decid::Random* random, std::span<float> input, std::span<float> target) {
            const bool whole = sample < count / 2 || (random != nullptr) != in_training;
            std::ranges::fill(input.first(of_input && !whole ? 2 : 3), 1.0F);
            std::ranges::fill(target.first(of_input || whole ? 2 : 1), 1.0F);
          });
      Network<float> network(shape, "fc 4; relu; fc 2");
      o.validation = 0.5;
      check_error([&] { fit(network, partly, o); }, Code::value_invalid,
                  of_input ? "value 2 of the inputs" : "value 1 of the targets");
    }
  const Samples batches(count, [](const Samples::Batch& batch) {
    std::ranges::fill(batch.inputs.first(batch.inputs.size() - (batch.samples.back() > 3 ? 1 : 0)), 1.0F);
    std::ranges::fill(batch.targets, 1.0F);
  });
  Network<float> network(shape, "fc 4; relu; fc 2");
  check_error([&] { fit(network, batches, o); }, Code::value_invalid, "inputs");
  CHECK(std::isnan(mean_loss(initialised("fc 2"), batches, *squared_error())));
}

// A user's OpenMP loops in it would run in one thread.
TEST_CASE("fit: a function of batches is called outside of parallel regions") {
  int calls = 0;
  const Samples batches(count, [&](const Samples::Batch& batch) {
    CHECK(omp_in_parallel() == 0);
    ++calls;
    std::ranges::fill(batch.inputs, 1.0F);
    std::ranges::fill(batch.targets, 1.0F);
  });
  Network<float> network(shape, "fc 2");
  fit(network, batches, options());
  CHECK(calls == 2 * (5 + 1));  // 36 samples in batches of 8, then validation
}

TEST_CASE("fit: errors of a checkpoint name the first setting that differs, or the file that is none") {
  const Scratch file("refused");
  FitOptions o = options();
  o.checkpoint = file.path;
  const auto run = [&] {
    Network<float> network(shape, "fc 2");
    fit(network, samples(), o);
  };
  run();
  const std::string whole = decid::read_file(file.path);
  o.epochs = 3;
  o.seed = 2;
  check_error(run, Code::file_differs, "epochs 2 where this fit has epochs 3;");
  o.epochs = 2;
  check_error(run, Code::file_differs, "seed 1 where this fit has seed 2;");
  o.seed = 1;
  decid::write_file(file.path, std::string_view(whole).substr(0, whole.size() - 5));
  check_error(run, Code::file_damaged, "checkpoint");
  std::string changed = whole;
  changed.back() ^= 1;
  decid::write_file(file.path, changed);
  check_error(run, Code::file_damaged, "checkpoint");
  // Nobody is to delete a network.
  write_network(initialised("fc 2"), file.path);
  try {
    run();
    CHECK(false);
  } catch (const decid::Error& error) {
    CHECK(error.code() == Code::file_unsupported);
    CHECK(std::string(error.what()).find("delete") == std::string::npos);
  }
}

TEST_CASE("fit: a batch of one sample, left by larger ones, is named with the batch to give") {
  const Samples five{std::span(inputs()).first(15), std::span(targets()).first(10), 5};
  FitOptions o = options();
  o.batch = 2;
  o.validation = 0;
  const auto run = [&] {
    Network<float> network(shape, "fc 4; batchnorm; relu; fc 2");
    fit(network, five, o);
  };
  check_error(run, Code::setting_out_of_range, "leave one of 1: give a batch of 3");
  o.batch = 3;
  run();
}

TEST_CASE("fit: a target that is no class is named before the first step, in validation too") {
  std::vector<float> classes(count, 1.0F);
  classes[12] = 2;
  FitOptions o = options();
  o.loss = cross_entropy();
  o.after_batch = [](int, int, double) -> bool { throw std::logic_error("a step was done"); };
  Network<float> network(shape, "fc 2");
  const Samples odd(inputs(), classes, count);
  check_error([&] { fit(network, odd, o); }, Code::setting_out_of_range, "sample 12 ");
  o.validation_samples = odd;
  const std::vector<float> right(count, 1.0F);
  check_error([&] { fit(network, {inputs(), right, count}, o); }, Code::setting_out_of_range, "sample 12 ");
}

TEST_CASE("losses of no samples, and optimisers with a negative memory") {
  cross_entropy()->batch({}, {}, {}, {});  // divides by no number of samples
  class Negative final : public Optimiser {
   public:
    void update(const Values&, double, long long) const override {}
    int memory() const override { return -1; }
    std::string text() const override { return "negative"; }
  };
  check_error([] { begin(Negative(), Network<float>(shape, "fc 2")); }, Code::setting_out_of_range, "negative");
}
