#include "posterior/frf/density.hpp"

#include "posterior/cholesky.hpp"
#include "sim/body_model.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/frf/made_table.hpp"

using namespace decid;
using namespace decid::test;
using frf::Density;

namespace {

frf::Local evaluated(const Density& density, const std::vector<double>& x) {
  frf::Local local;
  local.gradient.resize(density.size());
  local.information.resize(posterior::triangle(density.size()));
  density.evaluate(x, local);
  return local;
}

/// A stable controller with much passing, away from all edges.
const std::vector<double> middle = {0.6, 0.5, 0.4, 0.5, 0.63, 0.4, 0.4, 0.55, 0.8};

}  // namespace

TEST_CASE("a state's values follow from its coordinates") {
  const Density density(sim::short_protocol(), empty_table(short_frequencies_hz, 0.1), {.gain = 0.2});
  const sim::ParameterTable& ranges = sim::single_pendulum().parameters;
  const frf::State state = density.state(middle);
  CHECK(near(state.parameters[sim::Kp], ranges[sim::Kp].low + 0.6 * ranges[sim::Kp].range(), 1e-12));
  CHECK(near(state.gain, 0.8 + 0.4 * 0.55, 1e-12));
  CHECK(near(state.error, 0.01 * std::pow(3.0, 0.8), 1e-12));
  CHECK(density.value(state, sim::Delay) == state.parameters[sim::Delay]);
  CHECK(density.value(state, density.gain()) == state.gain);
  CHECK(density.value(state, density.error()) == state.error);
}

TEST_CASE("the misfit is that of the errors, written out") {
  const frf::Table table = empty_table({0.05, 0.4, 1.1}, 0.1);
  const Density density(sim::short_protocol(), table, {});
  const frf::State state = density.state(middle);
  std::vector<sim::Complex> responses(3);
  density.model().respond(state.parameters, responses);
  double expected = 0.0, chi_square = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const sim::Complex response = state.gain * responses[i];
    const double variance = 0.01 + state.error * state.error * std::norm(response);
    expected += 0.5 * std::norm(1.0 - response) / variance + std::log(variance);
    chi_square += std::norm(1.0 - response) / 0.01;
  }
  CHECK(near(evaluated(density, middle).misfit, expected, 1e-12));
  CHECK(near(density.chi_square(state, 0.0), chi_square, 1e-12));
}

// Central differences err by h^2 times the third derivative, some 1e2 of the gradient, and by 1e-16 / h of the misfit.
TEST_CASE("the gradient is that of finite differences") {
  const double h = 1e-5;
  for (const double deviation : {0.0, 0.05}) {
    const Density density(sim::short_protocol(), empty_table(short_frequencies_hz, deviation), {});
    const frf::Local local = evaluated(density, middle);
    double largest = 0.0;
    for (const double value : local.gradient) largest = std::max(largest, std::abs(value));
    for (std::size_t i = 0; i < density.size(); ++i) {
      if (i == sim::Nv || i == sim::Theta) continue;
      CAPTURE(i);
      std::vector<double> below = middle, above = middle;
      below[i] -= h;
      above[i] += h;
      const double expected = (evaluated(density, above).misfit - evaluated(density, below).misfit) / (2.0 * h);
      CHECK(within(local.gradient[i], expected, 1e-6 * largest));
    }
    // The passed fraction is linear between the blocks of its ranks: a block's slope is the slope over its 1/512.
    std::vector<double> below = middle, above = middle;
    below[sim::Nv] -= 0.01;
    above[sim::Nv] += 0.01;
    const double expected = (evaluated(density, above).misfit - evaluated(density, below).misfit) / 0.02;
    CHECK(near(local.gradient[sim::Nv], expected, 0.2));
  }
}

TEST_CASE("the information is that of the responses' and variances' finite differences") {
  const Density density(sim::short_protocol(), empty_table(short_frequencies_hz, 0.05), {});
  const std::size_t rows = short_frequencies_hz.size();
  const double h = 1e-5;
  const auto at = [&](std::size_t quantity, double shift, std::vector<sim::Complex>& responses,
                      std::vector<double>& log) {
    std::vector<double> x = middle;
    x[quantity] += shift;
    const frf::State state = density.state(x);
    responses.resize(rows);
    density.respond(state, responses);
    for (std::size_t row = 0; row < rows; ++row)
      log.push_back(std::log(density.variance(row, responses[row], state.error)));
  };
  std::vector<std::vector<sim::Complex>> by(density.size(), std::vector<sim::Complex>(rows));
  std::vector<std::vector<double>> by_log(density.size(), std::vector<double>(rows));
  for (std::size_t q = 0; q < density.size(); ++q) {
    std::vector<sim::Complex> low, high;
    std::vector<double> log_low, log_high;
    at(q, -h, low, log_low);
    at(q, h, high, log_high);
    for (std::size_t row = 0; row < rows; ++row) {
      by[q][row] = (high[row] - low[row]) / (2.0 * h);
      by_log[q][row] = (log_high[row] - log_low[row]) / (2.0 * h);
    }
  }
  std::vector<sim::Complex> here;
  std::vector<double> log_here;
  at(0, 0.0, here, log_here);
  const frf::Local local = evaluated(density, middle);
  const auto is_smooth = [](std::size_t q) { return q != sim::Nv && q != sim::Theta; };
  for (std::size_t i = 0; i < density.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      if (!is_smooth(i) || !is_smooth(j)) continue;
      double expected = 0.0, scale = 0.0;
      for (std::size_t row = 0; row < rows; ++row) {
        const double precision = std::exp(-log_here[row]);
        expected += precision * std::real(std::conj(by[i][row]) * by[j][row]) + by_log[i][row] * by_log[j][row];
        scale += precision * std::abs(by[i][row]) * std::abs(by[j][row]) + std::abs(by_log[i][row] * by_log[j][row]);
      }
      CAPTURE(i);
      CAPTURE(j);
      CHECK(within(local.information[posterior::triangle(i) + j], expected, 1e-6 * scale));
    }
  }
}

TEST_CASE("an unstable loop is impossible") {
  const Density density(sim::short_protocol(), empty_table(short_frequencies_hz, 0.05), {});
  std::vector<double> x = middle;
  x[sim::Delay] = 0.999;
  x[sim::Kp] = 0.999;
  CHECK_FALSE(density.is_stable(density.state(x)));
  CHECK(std::isinf(evaluated(density, x).misfit));
}

TEST_CASE("priors out of their bounds are errors") {
  const auto with = [](const frf::Priors& priors, double deviation) {
    return [=] { Density(sim::short_protocol(), empty_table({0.05, 0.4, 1.1}, deviation), priors); };
  };
  check_error(with({.gain = -0.1}, 0.1), {"gain", "is -0.1", "0 to 0.9"});
  check_error(with({.gain = 1.0}, 0.1), {"gain", "is 1"});
  check_error(with({.error = 2.0}, 0.1), {"error", "is 2"});
  check_error(with({.error_factor = 1.0}, 0.1), {"error_factor", "is 1"});
  check_error(with({.error = 0.0}, 0.0), {"made.csv", "no confidence", "error above 0"});
  CHECK(Density(sim::short_protocol(), empty_table({0.05, 0.4, 1.1}, 0.1), {}).priors().error == 0.01);
  CHECK(Density(sim::short_protocol(), empty_table({0.05, 0.4, 1.1}, 0.0), {}).priors().error == 0.05);
}
