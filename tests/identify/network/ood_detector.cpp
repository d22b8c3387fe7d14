// Out-of-distribution detection: whitened features against a covariance inverted by hand, what is usual, and networks
// that have none.
#include "identify/network/ood_detector.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.hpp"
#include "base/math/random.hpp"
#include "identify/network/model.hpp"
#include "nn/predictor.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"

namespace decid {
namespace {

using namespace test;

constexpr std::size_t features = 3;
using Vector = std::array<double, features>;
using Matrix = std::array<Vector, features>;

sim::Protocol protocol() {
  sim::Protocol brief;
  brief.experiment.stimulus = sim::Sines{.components = {{0.25, 0.5, 0.0}}, .cycle_s = 4.0};
  return brief;
}

/// Two rows of four windows of the spectrum's real part: 8 values.
Model model(const std::string& architecture = "fc 3; fc 7") {
  Model made(protocol(), {.window = 100, .half_spectrum = true, .channels = {dataset::Channel::real}, .rows = 2},
             architecture);
  made.network.initialise(3);
  return made;
}

/// Noise of 0.02 rad instead of simulated sway.
std::vector<float> sway_of(int trial) {
  const Random random(11, sim::streams::sensor_noise, static_cast<std::uint64_t>(trial));
  std::vector<float> sway(400);
  for (std::size_t k = 0; k < sway.size(); ++k) sway[k] = static_cast<float>(0.02 * random.normal(k));
  return sway;
}

/// `count` trials that nothing was trained on, all of the epoch that is asked for.
class Unseen final : public dataset::TrialSource {
 public:
  explicit Unseen(int count) : count_(count), protocol_(decid::protocol()) {}
  const sim::Protocol& protocol() const override { return protocol_; }
  dataset::TrialIdentity identity() const override { return {}; }
  int trials(dataset::Part part) const override { return part == dataset::Part::unseen ? count_ : 1; }
  int trials_at_once() const override { return 7; }
  void take(dataset::Part part, int epoch, std::span<const int> indices, const Take& take) const override {
    REQUIRE(part == dataset::Part::unseen);
    CHECK(epoch == 5);
    for (std::size_t i = 0; i < indices.size(); ++i)
      take(i, sim::single_pendulum().parameters.middle(), sway_of(indices[i]));
  }

 private:
  int count_;
  sim::Protocol protocol_;
};

std::vector<float> images_of(const Model& of, int trials) {
  const auto values = static_cast<std::size_t>(of.images().shape().size());
  std::vector<float> images(static_cast<std::size_t>(trials) * values);
  for (int i = 0; i < trials; ++i)
    of.make_input(sway_of(i), std::span(images).subspan(static_cast<std::size_t>(i) * values, values));
  return images;
}

std::vector<double> distances(const Model& of, int trials, std::span<const float> images) {
  nn::Predictor predictor(of.network, trials);
  const auto n = static_cast<std::size_t>(predictor.feature_count());
  std::vector<float> outputs(static_cast<std::size_t>(trials) * sim::single_pendulum().parameters.size()),
      read(static_cast<std::size_t>(trials) * n);
  predictor.run(images, outputs, read);
  std::vector<double> all;
  for (std::size_t i = 0; i < read.size(); i += n)
    all.push_back(of.ood_detector.distance(std::span(read).subspan(i, n)));
  return all;
}

/// Returns the first layer's features of a network input, in double.
Vector features_of(const Model& of, std::span<const float> image) {
  const std::vector<float>&weight = of.network.parameters()[0]->value, &bias = of.network.parameters()[1]->value;
  Vector made{};
  for (std::size_t i = 0; i < features; ++i) {
    made[i] = static_cast<double>(bias[i]);
    for (std::size_t k = 0; k < image.size(); ++k)
      made[i] += static_cast<double>(weight[i * image.size() + k]) * static_cast<double>(image[k]);
  }
  return made;
}

/// By Cramer's rule.
Matrix inverse_of(const Matrix& m) {
  const auto minor = [&](std::size_t row, std::size_t column) {
    const std::size_t a = (row + 1) % 3, b = (row + 2) % 3, c = (column + 1) % 3, d = (column + 2) % 3;
    return m[a][c] * m[b][d] - m[a][d] * m[b][c];
  };
  double determinant = 0;
  for (std::size_t j = 0; j < 3; ++j) determinant += m[0][j] * minor(0, j);
  Matrix inverse;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) inverse[j][i] = minor(i, j) / determinant;
  return inverse;
}

}  // namespace

TEST_CASE("OodDetector: features of another number are refused") {
  const OodDetector known{{0.0F, 1.0F}, {1.0F, 0.0F, 2.0F}, 1.0};
  const std::vector<float> values(3, 1.0F);
  CHECK(near(known.distance(std::span(values).first(2)), std::sqrt(0.5), 1e-15));
  check_error([&] { known.distance(std::span(values).first(1)); }, Code::size_mismatch, "1 features");
  CHECK_THROWS_AS(known.distance(values), Error);
  CHECK_THROWS_AS((OodDetector{{0.0F, 1.0F}, {1.0F, 0.0F}, 1.0}.distance(std::span(values).first(2))), Error);
  CHECK_THROWS_AS(OodDetector{}.distance({}), Error);
}

TEST_CASE("OodDetector: the Mahalanobis distance over the number of features, usual for 97 of 100") {
  constexpr int trials = 200, learned = 120;
  Model known = model();
  known.ood_detector = learn_ood_detector(known, Unseen(trials), 5);
  REQUIRE(known.ood_detector.known());
  REQUIRE(known.ood_detector.mean.size() == features);
  REQUIRE(known.ood_detector.whitening.size() == 6);
  const std::vector<float> images = images_of(known, trials);
  const std::vector<double> found = distances(known, trials, images);
  REQUIRE(found.size() == trials);

  // The same from the mean and the covariance of the first 120 trials, with a thousandth of the mean variance added.
  const std::size_t values = images.size() / trials;
  std::vector<Vector> all;
  for (std::size_t i = 0; i < trials; ++i)
    all.push_back(features_of(known, std::span(images).subspan(i * values, values)));
  Vector mean{};
  for (std::size_t t = 0; t < learned; ++t)
    for (std::size_t i = 0; i < features; ++i) mean[i] += all[t][i] / learned;
  Matrix covariance{};
  for (std::size_t t = 0; t < learned; ++t)
    for (std::size_t i = 0; i < features; ++i)
      for (std::size_t j = 0; j < features; ++j)
        covariance[i][j] += (all[t][i] - mean[i]) * (all[t][j] - mean[j]) / learned;
  const double ridge = 1e-3 * (covariance[0][0] + covariance[1][1] + covariance[2][2]) / features;
  for (std::size_t i = 0; i < features; ++i) covariance[i][i] += ridge;
  const Matrix inverse = inverse_of(covariance);
  double squares = 0, trace = 0;
  for (std::size_t t = 0; t < trials; ++t) {
    double square = 0;
    for (std::size_t i = 0; i < features; ++i)
      for (std::size_t j = 0; j < features; ++j)
        square += (all[t][i] - mean[i]) * inverse[i][j] * (all[t][j] - mean[j]) / features;
    // Features, mean and whitening are floats: some 2^-24 of numbers of the size of the largest distances.
    CHECK(within(found[t], std::sqrt(square), 2e-6));
    if (t < learned) squares += found[t] * found[t] / learned;
  }
  // The mean over the trials learned from is 1, except for the ridge: trace of (covariance - ridge) / covariance,
  // over 3.
  for (std::size_t i = 0; i < features; ++i) trace += inverse[i][i];
  CHECK(within(squares, 1.0 - ridge * trace / features, 2e-6));
  CHECK(within(std::sqrt(squares), 1.0, 0.01));

  // The border is the 78th of the 80 other distances.
  std::vector<double> others(found.begin() + learned, found.end());
  std::ranges::sort(others);
  CHECK(known.ood_detector.usual == others[77]);
}

TEST_CASE("OodDetector: trials of another kind are farther") {
  Model known = model();
  known.ood_detector = learn_ood_detector(known, Unseen(200), 5);
  std::vector<float> image = images_of(known, 1), far = image;
  for (float& value : far) value *= 10;
  CHECK(near(distances(known, 1, far).front(), 10 * distances(known, 1, image).front(), 0.5));
  CHECK(distances(known, 1, far).front() > known.ood_detector.usual);
}

TEST_CASE("OodDetector: features that are always the same can be divided by") {
  Model known = model();
  auto& weight = known.network.parameters()[0]->value;
  std::fill_n(weight.begin() + 8, 8, 0.0F);  // the second feature's
  known.ood_detector = learn_ood_detector(known, Unseen(200), 5);
  REQUIRE(known.ood_detector.known());
  const std::vector<double> found = distances(known, 10, images_of(known, 10));
  for (const double distance : found) CHECK((distance > 0 && distance < 5));
}

TEST_CASE(
    "OodDetector: features are the inputs of a last layer fc, if few; it takes eight trials of each, of three fifths") {
  struct Case {
    const char* architecture;
    int features, trials;
    std::string why;  ///< there is none
  };
  for (const auto& [architecture, count, trials, why] :
       {Case{"fc 3; fc 7", 3, 40, ""}, Case{"fc 3; fc 7", 3, 39, "it takes 40 trials"},
        Case{"fc 5; relu; fc 7", 5, 100, ""}, Case{"fc 512; fc 7", 512, 3, "it takes 6827 trials"},
        Case{"fc 513; fc 7", 0, 10'000, "reads 513 features"}, Case{"fc 7; relu", 0, 3, "relu, is not fc"},
        Case{"fc 7", 0, 10'000, "has one layer"}}) {
    const Model made = model(architecture);
    CHECK(feature_count(made.network) == count);
    const std::string found = why_no_ood_detector(made, Unseen(trials));
    CHECK(found.empty() == why.empty());
    CHECK(contains(found, why));
    CHECK(learn_ood_detector(made, Unseen(trials), 5).known() == why.empty());
  }
}

}  // namespace decid
