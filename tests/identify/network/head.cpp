// The head defines the meaning of the outputs. A made-up head with two outputs for each of fourteen parameters trains,
// predicts and is evaluated as the point head is.
#include "identify/network/head.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/math/random.hpp"
#include "identify/evaluation/comparison.hpp"
#include "identify/network/prediction.hpp"
#include "identify/training/checkpoint.hpp"
#include "nn/safetensors.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/made_up_body.hpp"

namespace decid::test {
namespace {

/// An estimate and another value, which is drawn to 0, for each parameter.
class PairHead final : public Head {
 public:
  std::string name() const override { return "pair"; }
  std::size_t outputs(std::size_t parameters) const override { return 2 * parameters; }
  std::size_t loss_parts(std::size_t) const override { return 1; }
  void loss(const nn::TensorView<const float>& outputs, std::span<const float> targets, int trials, std::size_t count,
            std::span<double> parts, const nn::TensorView<float>& diff) const override {
    const int parameters = static_cast<int>(count);
    const float factor = 2.0F / static_cast<float>(trials * parameters);
    std::ranges::fill(parts, 0.0);
    for (int o = 0; o < 2 * parameters; ++o)
      for (int sample = 0; sample < outputs.blocks() * nn::lanes; ++sample) {
        if (sample >= outputs.batch()) {
          diff.at(sample, o, 0, 0) = 0.0F;
          continue;
        }
        const float target = o % 2 == 0 ? targets[static_cast<std::size_t>(sample * parameters + o / 2)] : 0.0F;
        const float error = outputs.at(sample, o, 0, 0) - target;
        diff.at(sample, o, 0, 0) = factor * error;
        parts[static_cast<std::size_t>(sample / nn::lanes)] += static_cast<double>(error) * static_cast<double>(error);
      }
  }
  double total_loss(std::span<const double> parts, std::size_t) const override {
    return std::accumulate(parts.begin(), parts.end(), 0.0);
  }
  void scores(std::span<const float> outputs, std::span<float> scores) const override {
    for (std::size_t p = 0; p < scores.size(); ++p) scores[p] = outputs[2 * p];
  }
};

const PairHead pair_head;

/// Trials whose sway tells the first parameter and no other; nobody has simulated them.
class MadeUpSource final : public dataset::TrialSource {
 public:
  const sim::Protocol& protocol() const override { return protocol_; }
  dataset::TrialIdentity identity() const override { return {}; }
  int trials(dataset::Part part) const override { return part == dataset::Part::training ? 96 : 32; }
  int trials_at_once() const override { return 40; }
  void take(dataset::Part part, int, std::span<const int> indices, const Take& take) const override {
    const sim::ParameterTable& table = protocol_.parameters();
    for (std::size_t place = 0; place < indices.size(); ++place) {
      const auto item = static_cast<std::uint64_t>(indices[place] + (part == dataset::Part::training ? 0 : 1000));
      const sim::Parameters parameters = dataset::base_trial(table, 5, item).parameters;
      const std::vector<double> unit = table.to_unit(parameters);
      const Random noise(6, sim::streams::sensor_noise, item);
      std::vector<float> sway(static_cast<std::size_t>(protocol_.samples()));
      for (std::size_t k = 0; k < sway.size(); ++k) {
        const double turns = static_cast<double>(k) / 20.0;
        sway[k] = static_cast<float>(unit[0] * std::sin(2.0 * sim::pi * turns) + 0.01 * noise.normal(k));
      }
      take(place, parameters, sway);
    }
  }

 private:
  sim::Protocol protocol_ = made_up_protocol();
};

TrainingSettings settings(const Head& head, const std::string& last_layer) {
  TrainingSettings made;
  made.preset = preset_named("small");
  std::string& layers = made.preset.architecture;
  layers = layers.substr(0, layers.rfind("fc ")) + last_layer;
  made.preset.epochs = 6;
  made.preset.batch = 20;
  made.head = &head;
  return made;
}

TrainingState trained(const dataset::TrialSource& source, const TrainingSettings& how) {
  TrainingState state = start_training(source, how);
  REQUIRE(run_training(
      source, how, state, [](int, int) { return true; }, [] {}));
  return state;
}

}  // namespace

TEST_CASE("the point head's loss is the squared error of every parameter, its gradient that of the mean") {
  nn::AlignedBuffer<float> memory, gradient;
  const nn::Shape shape{3, 1, 1};
  constexpr int batch = 18;
  for (nn::AlignedBuffer<float>* buffer : {&memory, &gradient})
    buffer->reserve(nn::TensorView<float>::required(shape, batch, {}));
  const nn::TensorView<float> outputs(memory.data(), shape, batch, {}), diff(gradient.data(), shape, batch, {});
  std::vector<float> targets(batch * 3);
  double sum = 0.0;
  for (int i = 0; i < batch; ++i)
    for (int o = 0; o < 3; ++o) {
      const float target = 0.25F * static_cast<float>(i % 5), output = 0.5F * static_cast<float>(o - i % 3);
      targets[static_cast<std::size_t>(3 * i + o)] = target;
      outputs.at(i, o, 0, 0) = output;
      sum += static_cast<double>((output - target) * (output - target));  // multiples of 1/16: exact
    }
  CHECK(point_head().outputs(3) == 3);
  CHECK(point_head().loss(outputs, targets, diff) == sum);
  for (int i = 0; i < batch; ++i)
    for (int o = 0; o < 3; ++o)
      CHECK(diff.at(i, o, 0, 0) ==
            2.0F / (batch * 3) * (outputs.at(i, o, 0, 0) - targets[static_cast<std::size_t>(3 * i + o)]));
  for (int lane = batch; lane < 2 * nn::lanes; ++lane) CHECK(diff.at(lane, 0, 0, 0) == 0.0F);
}

TEST_CASE("networks of fourteen parameters train with every head") {
  const MadeUpSource source;
  for (const Head* head : {&point_head(), static_cast<const Head*>(&pair_head), &mixture_head(1)}) {
    CAPTURE(head->name());
    const TrainingSettings how = settings(*head, "fc " + std::to_string(head->outputs(14)));
    const TrainingState state = trained(source, how);
    const Model& model = state.model;
    CHECK(model.head == head);
    CHECK(state.log.back().training_mse < state.log.front().training_mse);

    const Predicted predicted = predict(model, source, dataset::Part::validation);
    REQUIRE(predicted.scores.size() == 32 * 14);
    const Evaluation evaluation = evaluate(model.targets, predicted.scores, predicted.truth);
    REQUIRE(evaluation.mse_per_parameter.size() == 14);
    CHECK(evaluation.trials == 32);
    CHECK(evaluation.mse() == state.log.back().validation_mse);
    CHECK(near(evaluation.matlab_loss(), 7.0 * evaluation.mse(), 1e-15));
    // The network learns the parameter that the input determines, a density less well in few steps. The mean has MSE 1.
    CHECK(evaluation.mse_per_parameter[0] < (head == &mixture_head(1) ? 0.8 : 0.3));
    for (std::size_t p = 1; p < 14; ++p) CHECK(evaluation.mse_per_parameter[p] > 0.5);

    // The same figures from the parameters that the outputs stand for.
    std::vector<float> sway;
    std::vector<sim::Parameters> decoded;
    for (int i = 0; i < 32; ++i) {
      source.take(dataset::Part::validation, 0, std::vector<int>{i},
                  [&](std::size_t, const sim::Parameters&, const dataset::Sway& taken) {
                    sway.assign(taken.rad.begin(), taken.rad.end());
                  });
      const auto outputs = predict(model, 1, 1, sways_in_memory([&](int) { return std::span<const float>(sway); }));
      CHECK(outputs.size() == head->outputs(14));
      decoded.push_back(model.decode(outputs));
      REQUIRE(decoded.back().size() == 14);
    }
    const MethodFigures figures = compute_errors("network", "", decoded, predicted.truth, model.targets.stddev);
    REQUIRE(figures.mse_per_parameter.size() == 14);
    for (std::size_t p = 0; p < 14; ++p)  // targets were rounded to float
      CHECK(within(figures.mse_per_parameter[p], evaluation.mse_per_parameter[p], 1e-5));
    CHECK(within(figures.mse, evaluation.mse(), 1e-5));
  }
}

TEST_CASE("a network must have the outputs that its head needs") {
  const auto build = [](const Head& head, const std::string& last_layer) {
    return [&head, last_layer] {
      const TrainingSettings how = settings(head, last_layer);
      Model(made_up_protocol(), how.preset.image, how.preset.architecture, head);
    };
  };
  CHECK_NOTHROW(build(point_head(), "fc 14")());
  CHECK_NOTHROW(build(pair_head, "fc 28")());
  check_error(build(point_head(), "fc 7"), Code::setting_conflict, "14 outputs");
  check_error(build(pair_head, "fc 14"), Code::setting_conflict, "28 outputs");
}

TEST_CASE("model files name heads other than the point head, and one that nobody knows is refused") {
  const TrainingSettings how = settings(pair_head, "fc 14");
  Model paired(tiny_protocol(), how.preset.image, how.preset.architecture, pair_head);
  paired.targets.stddev = sim::single_pendulum().parameters.middle();
  const auto rows = static_cast<std::size_t>(paired.images().shape().channels * paired.images().shape().rows);
  paired.rows = {std::vector<float>(rows, 0.0F), std::vector<float>(rows, 1.0F)};
  check_error([&] { model_from_bytes(to_bytes(paired), "mine.safetensors"); }, Code::file_unsupported, "'pair'");
  Model pointed(tiny_protocol(), how.preset.image, settings(point_head(), "fc 7").preset.architecture);
  pointed.targets = paired.targets;
  pointed.rows = paired.rows;
  const std::string bytes = to_bytes(pointed);
  CHECK_FALSE(nn::from_safetensors(bytes, "bytes").metadata.contains("head"));
  CHECK(model_from_bytes(bytes, "bytes").head == &point_head());
  CHECK(&head_named("point", "bytes") == &point_head());
  CHECK(&chosen_head("mixture 16", "--head") == &mixture_head(16));
  check_error([] { chosen_head("mixture 17", "--head"); }, Code::setting_unknown, "1 to 16");
}

}  // namespace decid::test
