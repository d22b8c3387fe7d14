// Mixtures of Gaussians: the density against its formula, the gradient against differences, moments and quantiles
// against draws.
#include "identify/network/mixture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "identify/network/head.hpp"
#include "sim/body_model.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::test;

namespace {

std::vector<double> some_outputs(std::size_t components, std::size_t parameters, std::uint64_t item, double size) {
  std::vector<double> outputs(mixture_outputs(components, parameters));
  Random(8, Stream::weights, item).fill_normal(outputs);
  for (double& value : outputs) value *= size;
  return outputs;
}

}  // namespace

TEST_CASE("Mixture: the density of one and of two Gaussians of two coordinates") {
  // A = (2 0; 0.5 3), centre (0.3, -0.2).
  const std::vector<double> one{0.7, 0.3, -0.2, std::log(2.0), std::log(3.0), 0.5}, x{1.0, 0.5};
  std::vector<double> gradient(6);
  const double a = 2.0 * 0.7, b = 0.5 * 0.7 + 3.0 * 0.7;
  const double expected = std::log(6.0 / (2.0 * 3.14159265358979323846)) - 0.5 * (a * a + b * b);
  CHECK(near(mixture_log_density(1, one, x, gradient), expected, 1e-14));
  CHECK(gradient[0] == 0.0);
  std::vector<double> two = one, both(12);
  two.insert(two.end(), {0.7 + std::log(3.0), 0.3, -0.2, std::log(2.0), std::log(3.0), 0.5});
  CHECK(near(mixture_log_density(2, two, x, both), expected, 1e-13));
  CHECK(within(both[0], 0.0, 1e-15));
  two[7] = 1.3;
  const double other = std::log(6.0 / (2.0 * 3.14159265358979323846)) - 0.5 * (0.6 * 0.6 + 1.95 * 1.95);
  CHECK(
      near(mixture_log_density(2, two, x, both), std::log(0.25 * std::exp(expected) + 0.75 * std::exp(other)), 1e-13));
}

TEST_CASE("Mixture: the gradient is that of the density") {
  for (const std::size_t components : {1U, 3U}) {
    constexpr std::size_t parameters = 4;
    std::vector<double> outputs = some_outputs(components, parameters, components, 0.7);
    outputs[1 + parameters] = 8.0;  // cut off: the density does not change with it
    const std::vector<double> x{0.2, -1.1, 0.6, 1.4};
    std::vector<double> gradient(outputs.size()), unused(outputs.size());
    const double here = mixture_log_density(components, outputs, x, gradient);
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const double step = 6e-6, value = outputs[i];  // the cube root of epsilon
      outputs[i] = value + step;
      const double above = mixture_log_density(components, outputs, x, unused);
      outputs[i] = value - step;
      const double below = mixture_log_density(components, outputs, x, unused);
      outputs[i] = value;
      const double allowed = 100.0 * (std::numeric_limits<double>::epsilon() / step + step * step) * std::abs(here);
      CHECK(within(gradient[i], (above - below) / (2.0 * step), allowed + 1e-7 * std::abs(gradient[i])));
    }
    CHECK(gradient[1 + parameters] == 0.0);
  }
}

TEST_CASE("Mixture: balanced derivatives are the covariance times those by the centre, a fifth of those by A") {
  constexpr std::size_t count = 4, components = 2;
  const std::size_t each = mixture_outputs(1, count);
  std::vector<double> outputs = some_outputs(components, count, 5, 0.8);
  const std::vector<double> x{0.4, -0.9, 1.2, 0.1};
  std::vector<double> exact(outputs.size()), balanced(outputs.size());
  const double density = mixture_log_density(components, outputs, x, exact);
  CHECK(mixture_log_density(components, outputs, x, balanced, Gradients::balanced) == density);
  for (std::size_t k = 0; k < components; ++k) {
    const std::size_t first = k * each;
    CHECK(balanced[first] == exact[first]);
    for (std::size_t i = 1 + count; i < each; ++i)
      CHECK(within(balanced[first + i], 0.2 * exact[first + i], 1e-15 * std::abs(exact[first + i])));
    // A^t A times the balanced ones are the exact ones.
    std::array<std::array<double, count>, count> a{};
    for (std::size_t p = 0; p < count; ++p) {
      a[p][p] = std::exp(outputs[first + 1 + count + p]);
      for (std::size_t q = 0; q < p; ++q) a[p][q] = outputs[first + 1 + 2 * count + p * (p - 1) / 2 + q];
    }
    for (std::size_t p = 0; p < count; ++p) {
      double expected = 0.0;
      for (std::size_t q = 0; q < count; ++q)
        for (std::size_t m = 0; m < count; ++m) expected += a[m][p] * a[m][q] * balanced[first + 1 + q];
      CHECK(within(exact[first + 1 + p], expected, 1e-13));  // roundings, some tens
    }
  }
}

TEST_CASE("Mixture: means, deviations, correlations and quantiles are those of its draws") {
  constexpr std::size_t parameters = 3, components = 2;
  std::vector<double> outputs = some_outputs(components, parameters, 9, 0.5);
  const Mixture mixture(components, parameters, outputs);
  // x = centre + A^-1 z, solved row by row.
  const std::size_t each = mixture_outputs(1, parameters);
  const double fraction = 1.0 / (1.0 + std::exp(outputs[each] - outputs[0]));
  const Random random(11, Stream::weights, 1);
  constexpr std::size_t draws = 200'000;
  std::vector<std::vector<double>> drawn(parameters);
  for (std::size_t n = 0; n < draws; ++n) {
    const double* of = outputs.data() + (random.uniform(4 * n) < fraction ? 0 : each);
    double off[parameters];
    for (std::size_t p = 0; p < parameters; ++p) {
      double left = random.normal(4 * n + 1 + p);
      for (std::size_t q = 0; q < p; ++q) left -= of[1 + 2 * parameters + p * (p - 1) / 2 + q] * off[q];
      off[p] = left / std::exp(of[1 + parameters + p]);
      drawn[p].push_back(normal_distribution(of[1 + p] + off[p]));
    }
  }
  // Five standard errors of 200,000 draws of at most 0.5.
  constexpr double error = 5.0 * 0.5 / 447.0;
  std::vector<double> mean(parameters, 0.0), stddev(parameters, 0.0);
  for (std::size_t p = 0; p < parameters; ++p) {
    for (const double value : drawn[p]) mean[p] += value / draws;
    for (const double value : drawn[p]) stddev[p] += (value - mean[p]) * (value - mean[p]) / draws;
    stddev[p] = std::sqrt(stddev[p]);
    CHECK(within(mixture.mean(p), mean[p], error));
    CHECK(within(mixture.stddev(p), stddev[p], error));
    CHECK(mixture.correlation(p, p) == 1.0);
  }
  for (std::size_t p = 1; p < parameters; ++p) {
    double product = 0.0;
    for (std::size_t n = 0; n < draws; ++n)
      product += (drawn[0][n] - mean[0]) * (drawn[p][n] - mean[p]) / draws / (stddev[0] * stddev[p]);
    CHECK(within(mixture.correlation(0, p), product, 2.0 * error));
    CHECK(within(mixture.correlation(p, 0), mixture.correlation(0, p), 1e-6));
  }
  for (std::size_t p = 0; p < parameters; ++p) {
    std::ranges::sort(drawn[p]);
    for (const double of : {0.05, 0.5, 0.9}) {
      const double found = mixture.quantile(p, of);
      const auto below = std::ranges::lower_bound(drawn[p], found) - drawn[p].begin();
      CHECK(within(static_cast<double>(below) / draws, of, error));
    }
  }
}

TEST_CASE("Mixture: another number of outputs is refused") {
  std::vector<double> gradient(5);
  check_error([&] { mixture_log_density(1, std::vector<double>(5), std::vector<double>(2), gradient); },
              Code::size_mismatch, "5 outputs");
  check_error([] { Mixture(2, 7, std::vector<double>(71)); }, Code::size_mismatch, "71 outputs");
  check_error([] { mixture_head(0); }, Code::setting_out_of_range, "0 components");
  check_error([] { mixture_head(17); }, Code::setting_out_of_range, "17 components");
}

TEST_CASE(
    "the mixture head's loss is minus the log density at the targets, its derivatives the balanced ones of the mean") {
  const Head& head = mixture_head(2);
  CHECK(&head_named("mixture 2", "test") == &head);
  CHECK(head.outputs(7) == 72);
  const sim::ParameterTable& table = sim::single_pendulum().parameters;
  const dataset::TargetScaling scaling = head.scaling(table, {});
  constexpr int batch = 18, parameters = 7, outputs = 72;
  nn::AlignedBuffer<float> memory, gradient;
  const nn::Shape shape{outputs, 1, 1};
  for (nn::AlignedBuffer<float>* buffer : {&memory, &gradient})
    buffer->reserve(nn::TensorView<float>::required(shape, batch, {}));
  const nn::TensorView<float> given(memory.data(), shape, batch, {}), diff(gradient.data(), shape, batch, {});
  const Random random(12, Stream::weights, 2);
  std::vector<float> targets;
  double expected = 0.0;
  std::vector<std::vector<double>> by(batch, std::vector<double>(outputs));
  for (int i = 0; i < batch; ++i) {
    std::vector<double> values, x;
    for (int o = 0; o < outputs; ++o) {
      given.at(i, o, 0, 0) = static_cast<float>(0.3 * random.normal(static_cast<std::uint64_t>(100 * i + o)));
      values.push_back(double{given.at(i, o, 0, 0)});
    }
    sim::Parameters truth(parameters);
    for (std::size_t p = 0; p < parameters; ++p) {
      const double fraction = random.uniform(5000 + static_cast<std::uint64_t>(10 * i) + p);
      truth[p] = table[p].low + fraction * table[p].range();
      x.push_back(inverse_normal(fraction));
    }
    const std::vector<float> scaled = scaling.scale(truth);
    targets.insert(targets.end(), scaled.begin(), scaled.end());
    expected -= mixture_log_density(2, values, x, by[static_cast<std::size_t>(i)], Gradients::balanced);
    std::vector<float> floats(values.begin(), values.end()), scores(parameters);
    head.scores(floats, scores);
    const Mixture mixture(2, parameters, values);
    const sim::Parameters mean = scaling.unscale(scores);
    for (std::size_t p = 0; p < parameters; ++p)
      CHECK(within(mean[p], table[p].low + mixture.mean(p) * table[p].range(), 1e-6 * table[p].range()));
  }
  CHECK(near(head.loss(given, targets, diff), expected, 1e-5));  // targets are floats
  for (int i = 0; i < batch; ++i)
    for (int o = 0; o < outputs; ++o) {
      const double exact = -by[static_cast<std::size_t>(i)][static_cast<std::size_t>(o)] / (batch * parameters);
      CHECK(within(double{diff.at(i, o, 0, 0)}, exact, 1e-5 * (1.0 + std::abs(exact))));
    }
  for (int lane = batch; lane < 2 * nn::lanes; ++lane) CHECK(diff.at(lane, 0, 0, 0) == 0.0F);
}
