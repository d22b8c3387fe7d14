// The predicted distribution of the parameters: moments, quantiles and densities against the network's mixture, with
// and without recalibration; which models have one.
#include "identify/network/distribution.hpp"

#include <cmath>

#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "identify/identify.hpp"
#include "sim/body_model.hpp"
#include "tests/helpers.hpp"

namespace decid::test {
namespace {

constexpr std::size_t parameters = 7;

const sim::ParameterTable& table() {
  return sim::single_pendulum().parameters;
}

Mixture mixture_of(std::size_t components) {
  std::vector<double> outputs(mixture_outputs(components, parameters));
  Random(21, Stream::weights, components).fill_normal(outputs);
  for (double& value : outputs) value *= 0.2;
  return {components, parameters, outputs};
}

/// Levels that lie outside of the nominal ones: of a network that promises too much.
Recalibration wide() {
  Recalibration made;
  for (std::size_t p = 0; p < parameters; ++p) {
    Recalibration::Levels& levels = made.levels.emplace_back();
    for (std::size_t i = 0; i < levels.size(); ++i)
      levels[i] = normal_distribution(1.5 * inverse_normal(0.05 * static_cast<double>(i + 1)));
    made.stddev_factor.push_back(1.5 + 0.1 * static_cast<double>(p));
  }
  return made;
}

}  // namespace

TEST_CASE("ParameterDistribution: its mixture's moments in SI units") {
  const Mixture mixture = mixture_of(2);
  const ParameterDistribution found(mixture, table());
  CHECK(found.parameters() == parameters);
  for (std::size_t p = 0; p < parameters; ++p) {
    const int quantity = static_cast<int>(p);
    const double low = table()[p].low, range = table()[p].range();
    CHECK(found.mean(quantity) == low + range * mixture.mean(p));
    CHECK(found.stddev(quantity) == range * mixture.stddev(p));
    CHECK(found.quantile(quantity, 0.3) == low + range * mixture.quantile(p, 0.3));
    CHECK(found.correlation(quantity, 0) == mixture.correlation(p, 0));
    CHECK(within(found.log_density(quantity, low + 0.4 * range), mixture.log_density(p, 0.4), 1e-12));
    // Outside of the range: as at its end, and surely above or below.
    CHECK(found.log_density(quantity, low - range) == found.log_density(quantity, low));
    CHECK(found.below(quantity, low - range) == 0.0);
    CHECK(found.below(quantity, low + 2.0 * range) == 1.0);
  }
}

TEST_CASE("ParameterDistribution: quantiles and deviations are recalibrated, the rest is not") {
  const Mixture mixture = mixture_of(2);
  const Recalibration recalibration = wide();
  const ParameterDistribution own(mixture, table()), found(mixture, table(), recalibration);
  const sim::Parameters middle = table().middle();
  CHECK(found.log_density(middle) == own.log_density(middle));
  for (std::size_t p = 0; p < parameters; ++p) {
    const int quantity = static_cast<int>(p);
    CHECK(found.mean(quantity) == own.mean(quantity));
    CHECK(found.correlation(quantity, 1) == own.correlation(quantity, 1));
    CHECK(found.log_density(quantity, middle[p]) == own.log_density(quantity, middle[p]));
    CHECK(near(found.stddev(quantity), (1.5 + 0.1 * static_cast<double>(p)) * own.stddev(quantity), 1e-15));
    CHECK(found.quantile(quantity, 0.05) == own.quantile(quantity, recalibration.levels[p].front()));
    CHECK(found.quantile(quantity, 0.05) < own.quantile(quantity, 0.05));
    CHECK(found.quantile(quantity, 0.95) > own.quantile(quantity, 0.95));
    // 50 halvings of 20 leave 2e-14 of a coordinate; densities of coordinates are below 7 here.
    for (const double probability : {0.01, 0.05, 0.5, 0.62, 0.99})
      CHECK(within(found.below(quantity, found.quantile(quantity, probability)), probability, 1e-10));
  }
}

TEST_CASE("Mixture: densities are derivatives of the distribution function, also joint ones") {
  for (const std::size_t components : {1U, 2U}) {
    const Mixture mixture = mixture_of(components);
    for (std::size_t p = 0; p < parameters; ++p)
      for (const double fraction : {0.03, 0.4, 0.9}) {
        const double step = 1e-5;
        const double slope = (mixture.below(p, fraction + step) - mixture.below(p, fraction - step)) / (2.0 * step);
        // Rounding 1e-16 / step, and the third derivative: below 1e5 of these densities.
        CHECK(within(std::exp(mixture.log_density(p, fraction)), slope, 1e-5 * (1.0 + slope)));
        CHECK(within(mixture.below(p, mixture.quantile(p, fraction)), fraction, 1e-12));
      }
  }
  // Independent parameters: centres and scales, nothing below the diagonal.
  std::vector<double> outputs(mixture_outputs(1, parameters));
  for (std::size_t p = 0; p < parameters; ++p) {
    outputs[1 + p] = 0.3 - 0.1 * static_cast<double>(p);
    outputs[1 + parameters + p] = 0.2 * static_cast<double>(p);
  }
  const Mixture independent(1, parameters, outputs);
  std::vector<double> fractions;
  double sum = 0.0;
  for (std::size_t p = 0; p < parameters; ++p) {
    fractions.push_back(0.2 + 0.1 * static_cast<double>(p));
    sum += independent.log_density(p, fractions.back());
  }
  CHECK(within(independent.log_density(fractions), sum, 1e-12));
  // With all outputs 0 every coordinate is standard normal: only the ranges are known.
  const Mixture ignorant(1, parameters, std::vector<double>(mixture_outputs(1, parameters), 0.0));
  CHECK(within(ignorant.log_density(fractions), 0.0, 1e-13));
  CHECK(within(ignorant.log_density(2, 0.77), 0.0, 1e-14));
  CHECK(within(ignorant.below(2, 0.77), 0.77, 1e-14));
  // Parameters far from their predicted range: no infinity.
  std::vector<double> sure(mixture_outputs(2, parameters), 0.0);
  sure[1] = sure[1 + mixture_outputs(1, parameters)] = 3.0;
  sure[1 + parameters] = sure[1 + parameters + mixture_outputs(1, parameters)] = mixture_limit;
  const double z = std::exp(mixture_limit) * 3.0;
  CHECK(near(Mixture(2, parameters, sure).log_density(0, 0.5), mixture_limit - 0.5 * z * z, 1e-12));
  CHECK(mixture_coordinate(0.0) == mixture_coordinate(1e-4));
  CHECK(mixture_coordinate(1.0) == mixture_coordinate(1.0 - 1e-4));
}

TEST_CASE("ParameterDistribution: other numbers of parameters are refused") {
  const std::vector<double> outputs(mixture_outputs(1, 3));
  check_error([&] { ParameterDistribution(Mixture(1, 3, outputs), table()); }, Code::size_mismatch, "3 parameters");
  Recalibration few = wide();
  few.levels.pop_back();
  check_error([&] { ParameterDistribution(mixture_of(1), table(), few); }, Code::size_mismatch, "6 of");
  check_error(
      [&] {
        static_cast<void>(ParameterDistribution(mixture_of(1), table()).log_density({1.0, 2.0}));
      },
      Code::size_mismatch, "2 values");
}

TEST_CASE("an estimate has the distribution of the model's head, recalibrated, and none of point estimates") {
  sim::Protocol protocol;
  protocol.experiment.stimulus = sim::Sines{.components = {{0.25, 0.5, 0.0}}, .cycle_s = 4.0};
  const dataset::ImageSettings image{
      .window = 100, .half_spectrum = true, .channels = {dataset::Channel::real}, .rows = 2};
  std::vector<double> sway;
  for (int k = 0; k < 400; ++k) sway.push_back(0.01 * std::sin(0.1 * k));

  Model point(protocol, image, "fc 7");
  point.network.initialise(1);
  CHECK_FALSE(point.gives_distribution());
  CHECK_FALSE(identify(point, sway, 100.0).estimate.distribution);
  CHECK_FALSE(point_head().distribution(std::vector<float>(7), 7));

  Model model(protocol, image, "fc 72", mixture_head(2));
  model.network.initialise(1);
  model.targets = model.head->scaling(table(), {});
  CHECK(model.gives_distribution());
  const Estimate own = identify(model, sway, 100.0).estimate;
  model.recalibration = wide();
  const Estimate found = identify(model, sway, 100.0).estimate;
  REQUIRE(own.distribution);
  REQUIRE(found.distribution);
  CHECK(found.parameters == own.parameters);
  for (std::size_t p = 0; p < parameters; ++p) {
    const int quantity = static_cast<int>(p);
    // Scores are floats, within 1.8 of 0.
    CHECK(within(found.parameters[p], found.distribution->mean(quantity), 1e-7 * table()[p].range()));
    CHECK(found.distribution->stddev(quantity) > 1.4 * own.distribution->stddev(quantity));
  }
  check_error([&] { static_cast<void>(model.distribution(std::vector<float>(71))); }, Code::size_mismatch,
              "71 outputs");
}

}  // namespace decid::test
