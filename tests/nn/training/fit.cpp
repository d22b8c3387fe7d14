// Tests of nn/fit.hpp: learning, bits for any number of threads, going on from checkpoints, what the options do.
#include "nn/fit.hpp"

#include <doctest/doctest.h>
#include <omp.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "base/files/file.hpp"
#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

namespace {

constexpr int count = 240, classes = 3;
constexpr Shape shape{1, 6, 6};
constexpr const char* text = "conv 4 3x3 pad 1; batchnorm; relu; maxpool 2; fc 3";

struct Data {
  std::vector<float> inputs, targets;
};

/// Noise, with a bright pair of columns that marks the class.
Data made(float brightness) {
  Data d{hashed_values<float>(1, count * 36), {}};
  for (std::size_t n = 0; n < count; ++n) {
    d.targets.push_back(static_cast<float>(n % classes));
    for (std::size_t i = 0; i < 36; ++i)
      if (i % 6 / 2 == n % classes) d.inputs[n * 36 + i] += brightness;
  }
  return d;
}
const Data& data() {
  static const Data bright = made(2.0F);
  return bright;
}
Samples samples() {
  return {data().inputs, data().targets, count};
}

FitOptions options() {
  FitOptions o;
  o.epochs = 4;
  o.batch = 20;
  o.learning_rate = 0.01;
  o.loss = cross_entropy();
  return o;
}

struct Fitted {
  Network<float> network{shape, text};
  FitLog log;
  std::string sha256;
};
Fitted fitted(const FitOptions& o, const Samples& from = samples()) {
  Fitted f;
  f.log = fit(f.network, from, o);
  f.sha256 = weights_sha256(f.network);
  return f;
}

std::string scratch(const std::string& name) {
  const std::string path = (std::filesystem::temp_directory_path() / ("decid_fit_" + name)).string();
  std::filesystem::remove(path);
  return path;
}

/// An optimiser as a program outside would add it: steps of the learning rate's size, by the gradient's sign.
class SignDescent final : public Optimiser {
 public:
  void update(const Values& v, double learning_rate, long long) const override {
    for (std::size_t i = 0; i < v.count; ++i)
      v.value[i] -= static_cast<float>(v.gradient[i] > 0 ? learning_rate : -learning_rate);
  }
  int memory() const override { return 0; }
  std::string text() const override { return "sign-descent"; }
};

/// Leaves no weight finite.
class Exploding final : public Optimiser {
 public:
  void update(const Values& v, double, long long) const override {
    std::fill_n(v.value, v.count, std::numeric_limits<float>::infinity());
  }
  int memory() const override { return 0; }
  std::string text() const override { return "exploding"; }
};

}  // namespace

TEST_CASE("fit: learns classes with each optimiser, one from outside among them") {
  const std::pair<std::shared_ptr<const Optimiser>, double> cases[]{
      {adamw(), 0.01}, {sgd(), 0.03}, {sgd({.nesterov = true}), 0.03}, {std::make_shared<SignDescent>(), 0.01}};
  for (const auto& one : cases) {
    CAPTURE(one.first->text());
    FitOptions o = options();
    o.optimiser = one.first;
    o.learning_rate = one.second;
    const Fitted f = fitted(o);
    REQUIRE(f.log.epochs.size() == 4);
    CHECK(f.log.finished);
    CHECK(f.log.kept == 4);
    CHECK(f.log.epochs[3].epoch == 4);
    CHECK(f.log.epochs[3].training_loss < 0.75 * f.log.epochs[0].training_loss);
    CHECK(f.log.epochs[3].validation_loss < 0.8);
    CHECK(accuracy(f.network, samples()) > 0.8);
    CHECK(mean_loss(f.network, samples(), *cross_entropy()) < 0.8);
  }
}

TEST_CASE("fit: the same bits for any number of threads, others for another seed") {
  const Threads kept(omp_get_max_threads());
  FitOptions o = options();
  o.average = 0.9;
  o.clip_norm = 0.5;
  o.optimiser = adamw();
  // Augmentation by counted numbers.
  const Samples noisy(count,
                      [](int sample, const decid::Random* random, std::span<float> input, std::span<float> target) {
                        samples().load()(sample, nullptr, input, target);
                        for (std::size_t i = 0; random != nullptr && i < input.size(); ++i)
                          input[i] += 0.1F * static_cast<float>(random->normal(i));
                      });
  omp_set_num_threads(1);
  const Fitted one = fitted(o, noisy);
  CHECK(one.sha256 != fitted(o).sha256);
  for (const int more : {2, 3, 8}) {
    omp_set_num_threads(more);
    CHECK(fitted(o, noisy).sha256 == one.sha256);
  }
  o.seed = 2;
  CHECK(fitted(o, noisy).sha256 != one.sha256);
}

// A change of this figure changes what every program trains that uses fit().
TEST_CASE("fit: pinned bits") {
  const Data dim = made(0.6F);
  CHECK(fitted(options(), {dim.inputs, dim.targets, count}).sha256 ==
        "d8b7a1196648e583a6d6e2edcc9b2246587b8af421bc1def8df348d5bff09274");
}

TEST_CASE("fit: goes on from a checkpoint to the bits of a training that was not stopped") {
  FitOptions o = options();
  o.average = 0.9;
  o.patience = 3;
  o.optimiser = adamw();
  const Fitted whole = fitted(o);
  o.checkpoint = scratch("checkpoint");
  // Stops after the third batch of the second epoch, then at an epoch's last batch, then not.
  int batches = 0;
  o.after_batch = [&](int epoch, int batch, double loss) {
    CHECK(std::isfinite(loss));
    CHECK(epoch >= 1);
    CHECK(batch >= 1);
    ++batches;
    return batches != 14 && batches != 22;
  };
  CHECK_FALSE(fitted(o).log.finished);
  const Fitted second = fitted(o);
  CHECK_FALSE(second.log.finished);
  CHECK(second.log.epochs.size() == 2);
  const Fitted last = fitted(o);
  CHECK(last.log.finished);
  CHECK(last.sha256 == whole.sha256);
  CHECK(last.log.kept == whole.log.kept);
  REQUIRE(last.log.epochs.size() == whole.log.epochs.size());
  for (std::size_t i = 0; i < last.log.epochs.size(); ++i) {
    CHECK(last.log.epochs[i].training_loss == whole.log.epochs[i].training_loss);
    CHECK(last.log.epochs[i].validation_loss == whole.log.epochs[i].validation_loss);
  }
  batches = 100;
  CHECK(fitted(o).sha256 == whole.sha256);  // of a fit that is done
  CHECK(batches == 100);
  FitOptions other = o;
  other.seed = 5;
  check_error([&] { fitted(other); }, decid::Code::file_differs);
  std::string bytes = decid::read_file(o.checkpoint);
  bytes[bytes.size() - 9] ^= 1;
  decid::write_file(o.checkpoint, bytes);
  check_error([&] { fitted(o); }, decid::Code::file_damaged);
  std::filesystem::remove(o.checkpoint);
}

TEST_CASE("fit: a checkpoint of another input is refused") {
  FitOptions o = options();
  o.epochs = 1;
  o.checkpoint = scratch("input");
  const Samples ones(count, [](int, const decid::Random*, std::span<float> input, std::span<float> target) {
    std::ranges::fill(input, 1.0F);
    target[0] = 0;
  });
  const char* all_sizes = "conv 3 3x3; globalavgpool";
  Network<float> small({1, 4, 4}, all_sizes), large({1, 5, 5}, all_sizes);
  fit(small, ones, o);
  check_error([&] { fit(large, ones, o); }, decid::Code::file_differs);
  std::filesystem::remove(o.checkpoint);
}

// The frozen lines of a checkpoint would replace those of a network that was trained on something else.
TEST_CASE("fit: a checkpoint of other frozen weights is refused") {
  FitOptions o = options();
  o.epochs = 2;
  o.frozen_lines = 4;
  o.average = 0.9;
  o.checkpoint = scratch("frozen");
  const auto fitted_from = [&](std::uint64_t seed) {
    Network<float> network(shape, text);
    network.initialise(seed);
    fit(network, samples(), o);
    return network;
  };
  const Network<float> first = fitted_from(9);
  CHECK(weights_sha256(fitted_from(9)) == weights_sha256(first));
  check_error([&] { fitted_from(10); }, decid::Code::file_differs);
  Network<float> again = first;
  again.parameters()[4]->value[0] += 1;  // of the last line, which the checkpoint has
  fit(again, samples(), o);
  CHECK(weights_sha256(again) == weights_sha256(first));
  std::filesystem::remove(o.checkpoint);
}

TEST_CASE("fit: the cosine after a warm-up begins at the learning rate") {
  FitOptions o = options();
  o.epochs = 4;
  o.batch = count;  // a step an epoch
  o.warmup_epochs = 2;
  o.learning_rate = 0.01;
  const FitLog log = fitted(o).log;
  REQUIRE(log.epochs.size() == 4);
  const double rates[]{0.005, 0.01, 0.01, 0.005};
  for (std::size_t i = 0; i < 4; ++i) CHECK(std::abs(log.epochs[i].learning_rate - rates[i]) < 1e-15);
}

TEST_CASE("fit: a checkpoint of other samples in memory is refused") {
  FitOptions o = options();
  o.epochs = 1;
  o.checkpoint = scratch("samples");
  const Data others = made(1.0F);
  std::vector<float> relabelled = data().targets;
  std::swap(relabelled[0], relabelled[1]);
  o.validation_samples = Samples(std::span(data().inputs).first(720), std::span(data().targets).first(20), 20);
  const std::string sha256 = fitted(o).sha256;
  CHECK(fitted(o).sha256 == sha256);
  check_error([&] { fitted(o, {others.inputs, data().targets, count}); }, decid::Code::file_differs, "samples");
  check_error([&] { fitted(o, {data().inputs, relabelled, count}); }, decid::Code::file_differs);
  check_error([&] { fitted(o, {count, samples().load()}); }, decid::Code::file_differs, "a function");
  o.validation_samples = Samples(std::span(data().inputs).last(720), std::span(data().targets).last(20), 20);
  check_error([&] { fitted(o); }, decid::Code::file_differs);
  std::filesystem::remove(o.checkpoint);
}

TEST_CASE("fit: a stop leaves the weights that the log names") {
  FitOptions o = options();
  o.average = 0.9;
  o.validation_samples = Samples(std::span(data().inputs).first(720), std::span(data().targets).first(20), 20);
  for (const int patience : {0, 3}) {
    o.patience = patience;
    int batches = 0;  // 12 an epoch; with patience the stop is within the second
    o.after_batch = [&](int, int, double) { return ++batches != (patience > 0 ? 15 : 12); };
    const Fitted f = fitted(o);
    CHECK_FALSE(f.log.finished);
    REQUIRE(f.log.epochs.size() == 1);
    CHECK(f.log.kept == 1);
    CHECK(mean_loss(f.network, *o.validation_samples, *o.loss) == f.log.epochs[0].validation_loss);
  }
}

TEST_CASE("fit: patience stops and keeps the best epoch") {
  FitOptions o = options();
  o.epochs = 50;
  o.schedule = "constant";
  o.learning_rate = 0.2;
  o.patience = 2;
  std::vector<std::string> hashes;
  Network<float> network(shape, text);
  o.after_epoch = [&](const FitEpoch&) { hashes.push_back(weights_sha256(network)); };
  const FitLog log = fit(network, samples(), o);
  CHECK(log.epochs.size() < 50);
  CHECK(log.kept == static_cast<int>(log.epochs.size()) - 2);
  CHECK(weights_sha256(network) == hashes.at(static_cast<std::size_t>(log.kept) - 1));
}

TEST_CASE("fit: frozen lines stay, weights that are there are not initialised") {
  FitOptions o = options();
  o.epochs = 1;
  o.frozen_lines = 4;
  Network<float> network(shape, text);
  network.initialise(9);
  const Network<float> before = network;
  fit(network, samples(), o);
  for (std::size_t k = 0; k < 4; ++k) CHECK(network.parameters()[k]->value == before.parameters()[k]->value);
  CHECK(network.parameters()[4]->value != before.parameters()[4]->value);
  CHECK(network.layers()[1].statistics()[0].value != before.layers()[1].statistics()[0].value);
}

TEST_CASE("fit: values that are not as new are not initialised, weights of 0 among them") {
  FitOptions o = options();
  o.epochs = 1;
  o.frozen_lines = 1;
  const Samples three(std::span(data().inputs).first(3 * count), data().targets, count);
  for (const char* line : {"layernorm", "fc 3"}) {
    Network<float> network({3, 1, 1}, line);
    network.parameters()[1]->value = {1, 2, 3};
    const std::string before = weights_sha256(network);
    fit(network, three, o);
    CHECK(weights_sha256(network) == before);
  }
}

TEST_CASE("fit: weights and a validation loss that are not finite are errors") {
  FitOptions o = options();
  o.epochs = 1;
  o.batch = count;  // one batch, whose loss is finite
  o.optimiser = std::make_shared<Exploding>();
  check_error([&] { fitted(o); }, decid::Code::diverged, "validation");
  o.validation = 0;
  check_error([&] { fitted(o); }, decid::Code::diverged, "weight");
}

TEST_CASE("fit: weights that are not finite are an error, also if after_batch stops the fit") {
  FitOptions o = options();
  o.optimiser = std::make_shared<Exploding>();
  o.after_batch = [](int, int batch, double) {
    CHECK(batch == 1);  // counted from 1
    return false;
  };
  Network<float> network(shape, text);
  check_error([&] { fit(network, samples(), o); }, decid::Code::diverged, "weight");
}

TEST_CASE("fit: validation samples are not trained on, or are those that are given") {
  FitOptions o = options();
  o.epochs = 1;
  std::vector<int> seen(count), validated(count);
  const Samples counted(count,
                        [&](int sample, const decid::Random* random, std::span<float> input, std::span<float> target) {
                          samples().load()(sample, nullptr, input, target);
                          ++(random != nullptr ? seen : validated)[static_cast<std::size_t>(sample)];
                        });
  fitted(o, counted);
  for (std::size_t i = 0; i < count; ++i) CHECK(seen[i] + validated[i] == 1);
  CHECK(std::count(validated.begin(), validated.end(), 1) == count / 10);
  o.validation = 0;
  CHECK(std::isnan(fitted(o).log.epochs[0].validation_loss));
  o.validation_samples = Samples(std::span(data().inputs).first(72), std::span(data().targets).first(2), 2);
  CHECK(fitted(o).log.epochs[0].validation_loss > 0);
}

TEST_CASE("fit: the first sample that is not finite is named, and no step is done") {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Data d = data();
    d.inputs[7 * 36 + 3] = d.inputs[9 * 36] = bad;
    const Samples memory(d.inputs, d.targets, count);
    Network<float> network(shape, text);
    network.initialise(3);
    const std::string before = weights_sha256(network);
    check_error([&] { fit(network, memory, options()); }, decid::Code::value_invalid,
                "value 3 of the inputs of sample 7,");
    CHECK(weights_sha256(network) == before);
    d.targets[5] = bad;
    check_error([&] { fit(network, memory, options()); }, decid::Code::value_invalid, "targets of sample 5,");
    FitOptions o = options();
    o.validation_samples = memory;
    check_error([&] { fitted(o); }, decid::Code::value_invalid);
  }
  // A function makes some in training, or in validation only, where there are no random numbers.
  FitOptions o = options();
  o.epochs = 1;
  for (const bool of_input : {true, false})
    for (const bool in_training : {true, false}) {
      const Samples odd(count,
                        [&](int sample, const decid::Random* random, std::span<float> input, std::span<float> target) {
                          samples().load()(sample, nullptr, input, target);
                          if ((random != nullptr) == in_training)
                            (of_input ? input : target)[0] = std::numeric_limits<float>::quiet_NaN();
                        });
      check_error([&] { fitted(o, odd); }, decid::Code::value_invalid,
                  of_input ? "value 0 of the inputs of sample" : "value 0 of the targets of sample");
    }
}

TEST_CASE("accuracy: outputs that are not finite are wrong, a target that is no class is refused") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Network<float> network({1, 1, 1}, "fc 3");
  const std::vector<float> input{1}, first{0};
  for (const float value : {1.0F, nan, std::numeric_limits<float>::infinity()}) {
    network.parameters()[1]->value = {value, 0, 0};
    CHECK(accuracy(network, {input, first, 1}) == (value == 1.0F ? 1 : 0));
  }
  for (const float wrong : {-1.0F, 0.5F, 3.0F, nan}) {
    const std::vector<float> target{wrong};
    check_error([&] { accuracy(network, {input, target, 1}); }, decid::Code::setting_out_of_range, "accuracy");
  }
}

TEST_CASE("fit: classes in planes are refused before the first step, also by accuracy and mean loss") {
  Network<float> network({1, 6, 6}, "conv 3 3");
  const std::string before = weights_sha256(network);
  FitOptions o = options();
  check_error([&] { fit(network, samples(), o); }, decid::Code::size_mismatch, "cross-entropy");
  check_error([&] { accuracy(network, samples()); }, decid::Code::size_mismatch, "accuracy");
  check_error([&] { mean_loss(network, samples(), *cross_entropy()); }, decid::Code::size_mismatch, "cross-entropy");
  Network<float> pooled({1, 6, 6}, "conv 3 3; globalavgpool");
  CHECK(fit(pooled, samples(), o).kept == o.epochs);
}

TEST_CASE("fit: weights set in some layers, where zeros of two others stop all gradients, are refused") {
  constexpr const char* three = "fc 5; relu; fc 4; relu; fc 3";
  FitOptions o = options();
  o.epochs = 1;
  const auto with = [&](const char* architecture, const std::vector<std::size_t>& zeros) {
    Network<float> network(shape, architecture);
    network.initialise(1);
    for (const std::size_t place : zeros) std::ranges::fill(network.parameters()[place]->value, 0.0F);
    return network;
  };
  const auto trains = [&](Network<float> network) {
    const std::string before = weights_sha256(network);
    fit(network, samples(), o);
    return weights_sha256(network) != before;
  };
  for (const std::vector<std::size_t>& zeros : {std::vector<std::size_t>{0, 2}, {0, 4}, {2, 4}})
    check_error([&] { trains(with(three, zeros)); }, decid::Code::setting_missing, "initialise()");
  CHECK(trains(with(three, {4})));              // of one before a relu see fit_samples.cpp
  CHECK(trains(Network<float>(shape, three)));  // new
  Network<float> biased = with(three, {0, 4});  // the last layer's weights have a gradient
  biased.parameters()[1]->value[0] = 1;
  CHECK(trains(biased));
  constexpr const char* blocks = "fc 4; residual { fc 4; relu; fc 4 }; residual { fc 4; relu; fc 4 }; fc 3";
  CHECK(trains(with(blocks, {4, 8})));  // the last layer of each block
  CHECK(trains(with(blocks, {4, 10})));
  check_error([&] { trains(with(blocks, {2, 4})); }, decid::Code::setting_missing, "initialise()");

  // A checkpoint's weights replace them.
  o.checkpoint = scratch("zeros");
  o.epochs = 2;
  Network<float> whole(shape, three);
  fit(whole, samples(), o);
  Network<float> partly = with(three, {2, 4});
  fit(partly, samples(), o);
  CHECK(weights_sha256(partly) == weights_sha256(whole));
  std::filesystem::remove(o.checkpoint);
}

TEST_CASE("fit: settings that do not fit are refused, those out of range by name") {
  using decid::Code;
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const auto refused = [](Code code, const char* fact, const std::function<void(FitOptions&)>& change) {
    FitOptions o = options();
    change(o);
    check_error([&] { fitted(o); }, code, fact);
  };
  struct Row {
    const char* name;
    void (*set)(FitOptions&, double);
    std::vector<double> values;
  };
  for (const Row& row :
       {Row{"epochs", [](FitOptions&o, double v) { o.epochs = static_cast<int>(v); }, {0}},
        {"batch", [](FitOptions&o, double v) { o.batch = static_cast<int>(v); }, {0}},
        {"validation", [](FitOptions&o, double v) { o.validation = v; }, {1}},
        {"average", [](FitOptions&o, double v) { o.average = v; }, {1}},
        {"clip_norm", [](FitOptions&o, double v) { o.clip_norm = v; }, {-1}},
        {"learning_rate", [](FitOptions&o, double v) { o.learning_rate = v; }, {-1, 0, nan, inf}},
        {"warmup_epochs", [](FitOptions&o, double v) { o.warmup_epochs = v; }, {-1, 1e30, nan, inf}},
        {"frozen_lines", [](FitOptions&o, double v) { o.frozen_lines = static_cast<int>(v); }, {-1, 6}}})
    for (const double value : row.values)
      refused(Code::setting_out_of_range, row.name, [&](FitOptions& o) { row.set(o, value); });
  refused(Code::setting_missing, "loss", [](FitOptions& o) { o.loss = nullptr; });
  refused(Code::setting_malformed, "'linear'", [](FitOptions& o) { o.schedule = "linear"; });
  refused(Code::size_mismatch, "", [](FitOptions& o) { o.loss = squared_error(); });  // three targets a sample
  for (const double fraction : {0.0, 0.002})
    refused(Code::setting_conflict, "patience", [&](FitOptions& o) {
      o.patience = 2;
      o.validation = fraction;
    });
  check_error([] { Samples(data().inputs, data().targets, 7 * count); }, Code::size_mismatch);
  FitOptions allowed = options();
  allowed.epochs = 1;
  allowed.frozen_lines = 5;
  allowed.validation = 0.002;
  CHECK(std::isnan(fitted(allowed).log.epochs[0].validation_loss));
  FitOptions diverges = options();
  diverges.optimiser = sgd();
  diverges.learning_rate = 1e5;
  diverges.loss = squared_error();
  const std::vector<float> huge(count * 3, std::numeric_limits<float>::max());
  check_error([&] { fitted(diverges, Samples(data().inputs, huge, count)); }, Code::diverged, "1");
}
