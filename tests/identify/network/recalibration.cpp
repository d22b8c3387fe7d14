// Recalibration: what it maps, that overconfident networks have the stated coverage on test trials, its file.
#include "identify/network/recalibration.hpp"

#include <omp.h>

#include <cmath>
#include <limits>
#include <vector>

#include "base/files/json_object.hpp"
#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "dataset/sets/dataset.hpp"
#include "identify/evaluation/calibration.hpp"
#include "nn/safetensors.hpp"
#include "tests/helpers.hpp"

namespace decid::test {
namespace {

constexpr std::size_t parameters = 7;

sim::Protocol brief_protocol() {
  sim::Protocol brief;
  brief.experiment.stimulus = sim::Sines{.components = {{0.25, 0.5, 0.0}}, .cycle_s = 4.0};
  return brief;
}

/// Knows nothing, as its weights are 0, and holds every coordinate for Gaussian with a deviation of 0.5.
Model too_sure(const std::string& architecture = "fc 36", const Head& head = mixture_head(1)) {
  Model made(brief_protocol(), {.window = 100, .half_spectrum = true, .channels = {dataset::Channel::real}, .rows = 2},
             architecture, head);
  made.targets = head.scaling(made.parameters(), {made.parameters().middle(), made.parameters().middle()});
  std::vector<float>& bias = made.network.parameters()[1]->value;
  if (bias.size() == 36)
    for (std::size_t p = 0; p < parameters; ++p) bias[1 + parameters + p] = static_cast<float>(std::log(2.0));
  return made;
}

/// Trials whose sway says nothing of their parameters, which are uniform over their ranges.
class Uninformed final : public dataset::TrialSource {
 public:
  explicit Uninformed(int count) : count_(count), protocol_(brief_protocol()) {}
  const sim::Protocol& protocol() const override { return protocol_; }
  dataset::TrialIdentity identity() const override { return {}; }
  int trials(dataset::Part part) const override { return part == dataset::Part::unseen ? count_ : 1; }
  int trials_at_once() const override { return 1000; }
  void take(dataset::Part part, int epoch, std::span<const int> indices, const Take& take) const override {
    REQUIRE(part == dataset::Part::unseen);
    const std::vector<float> sway(400, 0.01F);
    for (std::size_t place = 0; place < indices.size(); ++place) take(place, truth(epoch, indices[place]), sway);
  }
  static sim::Parameters truth(int epoch, int index) {
    return dataset::base_trial(sim::single_pendulum().parameters, 100 + static_cast<std::uint64_t>(epoch),
                               static_cast<std::uint64_t>(index))
        .parameters;
  }

 private:
  int count_;
  sim::Protocol protocol_;
};

const Recalibration& learned() {
  static const Recalibration made = learn_recalibration(too_sure(), Uninformed(20'000), 5);
  return made;
}

}  // namespace

TEST_CASE("errors or standard deviations that are all 0, or not finite, give no factor and are refused") {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const PredictedParameter& one : {PredictedParameter{0.5, 1.0, 0.0}, PredictedParameter{0.5, 0.0, 1.0},
                                        PredictedParameter{0.5, infinity, 1.0}, PredictedParameter{0.5, 0.0, 0.0}}) {
    CAPTURE(one.error);
    CAPTURE(one.stddev);
    check_error([&] { fit_recalibration(1, std::vector<PredictedParameter>(20, one)); }, Code::value_invalid);
  }
  CHECK(fit_recalibration(1, std::vector<PredictedParameter>(20, {0.5, 1.0, 2.0})).stddev_factor.front() == 0.5);
}

TEST_CASE("recalibration: piecewise linear from 0 through the levels to 1, and back") {
  const Recalibration none;
  CHECK_FALSE(none.known());
  CHECK(none.level(3, 0.3) == 0.3);
  CHECK(none.probability(3, 0.3) == 0.3);
  CHECK(none.factor(3) == 1.0);
  Recalibration made;
  Recalibration::Levels& levels = made.levels.emplace_back();
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const double nominal = 0.05 * static_cast<double>(i + 1);
    levels[i] = nominal * nominal;
  }
  levels[9] = levels[8];  // a level that stands twice
  made.stddev_factor = {2.0};
  CHECK(made.known());
  CHECK(made.factor(0) == 2.0);
  CHECK(made.level(0, 0.0) == 0.0);
  CHECK(made.level(0, 1.0) == 1.0);
  CHECK(near(made.level(0, 0.025), 0.5 * 0.0025, 1e-14));
  CHECK(near(made.level(0, 0.2), 0.04, 1e-12));
  CHECK(near(made.level(0, 0.97), 0.9025 + 0.4 * 0.0975, 1e-12));
  CHECK(made.probability(0, 0.0) == 0.0);
  CHECK(made.probability(0, 1.0) == 1.0);
  for (const double probability : {0.01, 0.05, 0.33, 0.44, 0.7, 0.95, 0.999})
    CHECK(near(made.probability(0, made.level(0, probability)), probability, 1e-12));
}

TEST_CASE(
    "recalibration: levels are quantiles of the predicted ones, the factor is the ratio of predicted to actual error") {
  // 99 trials in another order than their size: k of 100 are below with k %.
  std::vector<PredictedParameter> predicted;
  for (int i = 0; i < 99; ++i) {
    const double place = (i * 37) % 99 + 1;
    predicted.push_back({place / 200.0, 3.0, 1.0});
    predicted.push_back({1.0, i == 0 ? 30.0 : 1.0, i == 0 ? 1e-6 : 1.0});
  }
  const Recalibration made = fit_recalibration(2, predicted);
  for (std::size_t i = 0; i < Recalibration::probabilities; ++i) {
    CHECK(near(made.levels[0][i], 0.025 * static_cast<double>(i + 1), 1e-12));
    CHECK((made.levels[1][i] < 1.0 && made.levels[1][i] > 0.99));  // there is something to ask for
  }
  CHECK(near(made.stddev_factor[0], 3.0, 1e-14));
  // One trial that was sure and wrong does not decide for all.
  CHECK(near(made.stddev_factor[1], std::sqrt((900.0 + 98.0) / 98.0), 1e-12));
  check_error([&] { fit_recalibration(2, std::span(predicted).first(7)); }, Code::size_mismatch, "7 values");
  check_error([&] { fit_recalibration(2, {}); }, Code::size_mismatch, "0 values");
  check_error([&] { fit_recalibration(0, predicted); }, Code::size_mismatch, "0 parameters");
}

TEST_CASE("recalibration: an overconfident network has the stated coverage on test trials") {
  constexpr int fresh = 20'000;
  Model model = too_sure();
  std::vector<sim::Parameters> truth;
  for (int i = 0; i < fresh; ++i) truth.push_back(Uninformed::truth(6, i));
  const std::vector<float>& bias = model.network.parameters()[1]->value;
  std::vector<float> outputs;
  for (int i = 0; i < fresh; ++i) outputs.insert(outputs.end(), bias.begin(), bias.end());
  const NetworkCalibration before = *network_calibration(model, outputs, truth);
  model.recalibration = learned();
  REQUIRE(model.recalibration.known());
  const NetworkCalibration after = *network_calibration(model, outputs, truth);

  // Learnt from 10,240 trials and seen in 20,000: 4.9 standard errors of both, so that one in 10^6 is outside by
  // chance, 1.4e-5 of the fourteen.
  const auto allowed = [](double covered) {
    return 4.9 * std::sqrt(covered * (1.0 - covered) * (1.0 / 10'240 + 1.0 / fresh));
  };
  for (std::size_t p = 0; p < parameters; ++p) {
    const ParameterCalibration &of = after.figures.parameters[p], &was = before.figures.parameters[p];
    CHECK(within(of.coverage50, 0.5, allowed(0.5)));
    CHECK(within(of.coverage90, 0.9, allowed(0.9)));
    // Half as wide as the truth: coordinates within 1.645 / 2 and 0.674 / 2 of 0.
    CHECK(within(was.coverage90, 1.0 - 2.0 * normal_distribution(-0.82243), 4.9 * 0.5 / std::sqrt(fresh)));
    CHECK(within(was.coverage50, 1.0 - 2.0 * normal_distribution(-0.33724), 4.9 * 0.5 / std::sqrt(fresh)));
    // A uniform square has a mean of 1 (z-scored) and a relative deviation of sqrt(0.8).
    CHECK(within(of.predicted_variance, 1.0, 4.9 * std::sqrt(0.8 / 10'240)));
    CHECK(within(of.mse, 1.0, 4.9 * std::sqrt(0.8 / fresh)));
    CHECK(was.predicted_variance < 0.45);
    // The density is not recalibrated: log 2 - (4 - 1) x^2 / 2 with x^2 of mean 1 and variance 2.
    const double error = 4.9 * 1.5 * std::sqrt(2.0 / fresh);
    CHECK(within(after.log_score_per_parameter[p], std::log(2.0) - 1.5, error));
  }
  CHECK(within(after.figures.log_score, std::log(2.0) - 1.5, 4.9 * 1.5 * std::sqrt(2.0 / (7.0 * fresh))));
}

TEST_CASE("recalibration: the same for any number of threads") {
  const int threads = omp_get_max_threads();
  const Recalibration expected = learn_recalibration(too_sure(), Uninformed(1500), 5);
  for (const int count : {1, 3}) {
    omp_set_num_threads(count);
    CHECK(learn_recalibration(too_sure(), Uninformed(1500), 5) == expected);
  }
  omp_set_num_threads(threads);
}

TEST_CASE("recalibration: of distributions alone, from a thousand trials on") {
  CHECK_FALSE(learn_recalibration(too_sure(), Uninformed(999), 5).known());
  CHECK(learn_recalibration(too_sure(), Uninformed(1000), 5).known());
  const Model point = too_sure("fc 7", point_head());
  CHECK_FALSE(learn_recalibration(point, Uninformed(1000), 5).known());
  CHECK_FALSE(network_calibration(point, std::vector<float>(7), {}));
}

TEST_CASE("recalibration: survives a model file to the bit, and is left out where there is none") {
  Model model = too_sure();
  const std::string without = to_bytes(model);
  CHECK_FALSE(nn::from_safetensors(without, "m").metadata.contains("recalibration"));
  CHECK_FALSE(model_from_bytes(without, "m").recalibration.known());
  model.recalibration = learned();
  const std::string bytes = to_bytes(model);
  const Model copy = model_from_bytes(bytes, "m");
  CHECK(copy.recalibration == model.recalibration);
  CHECK(to_bytes(copy) == bytes);
  CHECK(nn::weights_sha256(copy.network) == nn::weights_sha256(model.network));
}

TEST_CASE("recalibration: a damaged one is refused") {
  Model model = too_sure();
  model.recalibration = learned();
  const Json whole = Json::parse(to_json(model.recalibration));
  const auto refused = [&](const std::string& text, const char* why, Code code = Code::file_damaged) {
    nn::TensorFile file = nn::from_safetensors(to_bytes(model), "m");
    file.metadata.erase(nn::content_hash_key);
    file.metadata["recalibration"] = text;
    check_error([&] { model_from_bytes(nn::to_safetensors(file), "mine"); }, code, why);
  };
  const auto changed = [&](const char* pointer, const Json& value) {
    Json json = whole;
    json[Json::json_pointer(pointer)] = value;
    return json.dump();
  };
  refused("{", "line 1", Code::setting_malformed);
  refused("[]", "cannot be read");
  refused("{}", "cannot be read");
  refused(changed("/levels", 3), "1 levels");
  refused(changed("/levels/2", Json::array({0.5})), "1 levels");
  refused(changed("/levels/2/4", "half"), "cannot be read");
  refused(changed("/levels/2/4", 0.99), "do not rise");
  refused(changed("/levels/2/0", 0.0), "do not rise");
  refused(changed("/levels/2/18", 1.0), "do not rise");
  refused(changed("/levels/2/18", nullptr), "cannot be read");
  refused(changed("/deviation_factor/6", 0.0), "not above 0");
  refused(changed("/deviation_factor/6", -1.0), "not above 0");
  refused(changed("/deviation_factor", Json::array({1.0})), "another number of parameters");
  Json six = whole;
  six["levels"].erase(6);
  refused(six.dump(), "another number of parameters");

  nn::TensorFile file = nn::from_safetensors(to_bytes(too_sure("fc 7", point_head())), "m");
  file.metadata.erase(nn::content_hash_key);
  file.metadata["recalibration"] = whole.dump();
  check_error([&] { model_from_bytes(nn::to_safetensors(file), "mine"); }, Code::file_damaged);
}

}  // namespace decid::test
