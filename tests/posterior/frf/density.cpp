#include "posterior/frf/density.hpp"

#include "base/math/cholesky.hpp"
#include "sim/body_model.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/frf/made_table.hpp"
#include "tests/sim/third_model.hpp"

using namespace decid;
using namespace decid::test;
using frf::Density;

namespace {

frf::Local evaluated(const Density& density, const std::vector<double>& x) {
  frf::Local local;
  local.gradient.resize(density.size());
  local.information.resize(triangle(density.size()));
  density.evaluate(x, local);
  return local;
}

/// A stable controller with much passing, away from all edges.
const std::vector<double> middle = {0.6, 0.5, 0.4, 0.5, 0.63, 0.4, 0.4, 0.55, 0.8};

/// A stable point in the middle of the priors.
std::vector<double> stable_point(const Density& density) {
  for (std::uint64_t i = 0;; ++i) {
    const Random random(21, sim::streams::base_parameters, i);
    std::vector<double> x;
    for (std::size_t k = 0; k < density.size(); ++k) x.push_back(0.3 + 0.4 * random.uniform(k));
    if (density.is_stable(density.state(x))) return x;
  }
}

/// The coordinates of Nv and theta; if both are free, they are the passing gain's rank and the place on its curve.
std::vector<std::size_t> dead_band_coordinates(const Density& density) {
  std::vector<std::size_t> coordinates;
  for (int p = 0; p < density.gain(); ++p) {
    const std::string& name = density.ranges()[static_cast<std::size_t>(p)].name;
    const auto coordinate = density.find_coordinate(p);
    if (coordinate && (name == "Nv" || name == "theta")) coordinates.push_back(*coordinate);
  }
  return coordinates;
}

/// Checks the gradient against central differences, whose error is some 1e2 h^2 of the largest part. Ranks of the
/// passing gain are piecewise linear: within a fifth.
void check_gradient(const Density& density, const std::vector<double>& x) {
  const double h = 1e-5;
  const frf::Local local = evaluated(density, x);
  double largest = 0.0;
  for (const double value : local.gradient) largest = std::max(largest, std::abs(value));
  const std::vector<std::size_t> ranks = dead_band_coordinates(density);
  for (std::size_t i = 0; i < density.size(); ++i) {
    CAPTURE(i);
    if (ranks.size() == 2 && std::ranges::count(ranks, i) > 0) continue;
    std::vector<double> below = x, above = x;
    below[i] -= h;
    above[i] += h;
    const double expected = (evaluated(density, above).misfit - evaluated(density, below).misfit) / (2.0 * h);
    CHECK(within(local.gradient[i], expected, 1e-6 * largest));
  }
}

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

TEST_CASE("the gradient is that of finite differences") {
  for (const double stddev : {0.0, 0.05}) {
    const Density density(sim::short_protocol(), empty_table(short_frequencies_hz, stddev), {});
    const frf::Local local = evaluated(density, middle);
    check_gradient(density, middle);
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
      CHECK(within(local.information[triangle(i) + j], expected, 1e-6 * scale));
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
  const auto with = [](const frf::Priors& priors, double stddev) {
    return [=] { Density(sim::short_protocol(), empty_table({0.05, 0.4, 1.1}, stddev), priors); };
  };
  check_error(with({.gain = -0.1}, 0.1), Code::setting_out_of_range, "-0.1");
  check_error(with({.gain = 1.0}, 0.1), Code::setting_out_of_range, "is 1");
  check_error(with({.error = 2.0}, 0.1), Code::setting_out_of_range, "is 2");
  check_error(with({.error_factor = 1.0}, 0.1), Code::setting_out_of_range, "error_factor");
  check_error(with({.error = 0.0}, 0.0), Code::setting_missing, "error above 0");
  CHECK(Density(sim::short_protocol(), empty_table({0.05, 0.4, 1.1}, 0.1), {}).priors().error == 0.01);
  CHECK(Density(sim::short_protocol(), empty_table({0.05, 0.4, 1.1}, 0.0), {}).priors().error == 0.05);
}

namespace {

using Fixed = std::optional<double>;
using Normal = posterior::ParameterPrior::Normal;

}  // namespace

TEST_CASE("gradients are those of finite differences for every model, with known parameters and normal priors") {
  for (const sim::BodyModel* model : {&sim::dec2015(), &sim::independent_channels(), &third_model()}) {
    CAPTURE(model->name);
    const sim::Protocol protocol = with_model(sim::short_protocol(), *model);
    const frf::Table table = empty_table(short_frequencies_hz, 0.05);
    const Density density(protocol, table, {});
    const auto fixed = static_cast<std::size_t>(std::ranges::count_if(
        model->parameters, [](const sim::ParameterInfo& info) { return info.convention.has_value(); }));
    CHECK(density.size() == model->parameters.size() - fixed + 2);
    const auto check = [](const Density& one) { check_gradient(one, stable_point(one)); };
    check(density);
    check(Density(protocol, table, {.parameters = {{"Kp", {}, Normal{900.0, 60.0}, {}}}}));
    check(Density(protocol, table, {.parameters = {{"Nv", {}, {}, Fixed(0.2)}, {"Kd", {}, {}, Fixed(250.0)}}}));
    if (model == &sim::independent_channels()) continue;
    check(Density(protocol, table, {.parameters = {{"theta", {}, {}, Fixed(0.003)}}}));
  }
}

TEST_CASE("known parameters have no coordinate") {
  const Density density(sim::short_protocol(), empty_table(short_frequencies_hz, 0.1),
                        {.parameters = {{"Kd", {}, {}, Fixed(250.0)}, {"theta", {}, {}, Fixed(0.002)}}});
  CHECK(density.size() == 7);
  CHECK(density.uniform() == 6);
  CHECK(density.is_fixed(sim::Kd));
  CHECK_FALSE(density.is_fixed(sim::Kp));
  CHECK_FALSE(density.find_coordinate(sim::Kd).has_value());
  CHECK(density.find_coordinate(sim::Delay) == 4);
  CHECK(density.find_coordinate(density.gain()) == 5);
  CHECK(density.find_coordinate(density.error()) == 6);
  const frf::State state = density.state(std::vector<double>(7, 0.5));
  CHECK(state.parameters[sim::Kd] == 250.0);
  CHECK(state.parameters[sim::Theta] == 0.002);
  CHECK(near(state.parameters[sim::Nv], 0.5, 1e-12));
}

TEST_CASE("normal priors have their mean and standard deviation, those of the dead band too") {
  const Density density(sim::short_protocol(), empty_table(short_frequencies_hz, 0.1),
                        {.parameters = {{"Kp", {}, Normal{900.0, 50.0}, {}},
                                        {"Nv", {}, Normal{0.4, 0.05}, {}},
                                        {"theta", {}, Normal{0.003, 0.0003}, {}}}});
  double kp = 0.0, nv = 0.0, theta = 0.0, kp_squares = 0.0, nv_squares = 0.0, theta_squares = 0.0;
  constexpr int draws = 4000;
  for (unsigned i = 0; i < draws; ++i) {
    const Random random(22, sim::streams::base_parameters, i);
    std::vector<double> x;
    for (std::size_t k = 0; k < density.size(); ++k)
      x.push_back(k < density.uniform() ? random.uniform(k) : random.normal(k));
    const sim::Parameters parameters = density.state(x).parameters;
    const double a = (parameters[sim::Kp] - 900.0) / 50.0, b = (parameters[sim::Nv] - 0.4) / 0.05,
                 c = (parameters[sim::Theta] - 0.003) / 0.0003;
    kp += a / draws, nv += b / draws, theta += c / draws;
    kp_squares += a * a / draws, nv_squares += b * b / draws, theta_squares += c * c / draws;
  }
  // 4.5 standard errors, 1 / sqrt(4000) and sqrt(2 / 4000).
  for (const double mean : {kp, nv, theta}) CHECK(within(mean, 0.0, 0.071));
  for (const double square : {kp_squares, nv_squares, theta_squares}) CHECK(within(square, 1.0, 0.1));
}

TEST_CASE("normal priors have normal coordinates, far out too, behind the gain") {
  const Density density(
      sim::short_protocol(), empty_table(short_frequencies_hz, 0.1),
      {.parameters = {
           {"Kp", {}, Normal{900.0, 20.0}, {}}, {"Nv", {}, {}, Fixed(0.2)}, {"theta", {}, Normal{0.002, 0.0001}, {}}}});
  CHECK(density.size() == 8);
  CHECK(density.uniform() == 5);
  CHECK(density.find_coordinate(sim::Kd) == 0);
  CHECK(density.find_coordinate(density.gain()) == 4);
  CHECK(density.find_coordinate(sim::Kp) == 5);
  CHECK(density.find_coordinate(sim::Theta) == 6);
  CHECK(density.find_coordinate(density.error()) == 7);
  for (const double sds : {-15.0, -3.0, 0.0, 3.0, 15.0}) {
    std::vector<double> x(8, 0.5);
    x[5] = sds;
    x[6] = -sds;
    const sim::Parameters parameters = density.state(x).parameters;
    CHECK(near(parameters[sim::Kp], 900.0 + 20.0 * sds, 1e-9));
    CHECK(near(parameters[sim::Theta], 0.002 - 0.0001 * sds, 1e-9));
  }
  CHECK(density.has_given_priors());
  CHECK_FALSE(Density(sim::short_protocol(), empty_table(short_frequencies_hz, 0.1), {}).has_given_priors());
}

TEST_CASE("gradients by Nv and theta with normal priors are those of finite differences") {
  const auto check = [](const std::vector<posterior::ParameterPrior>& priors) {
    const Density density(sim::short_protocol(), empty_table(short_frequencies_hz, 0.05), {.parameters = priors});
    std::vector<double> x(density.size(), 0.4);
    REQUIRE(density.is_stable(density.state(x)));
    const frf::Local local = evaluated(density, x);
    double largest = 0.0;
    for (const double value : local.gradient) largest = std::max(largest, std::abs(value));
    for (std::size_t i = 0; i < density.size(); ++i) {
      CAPTURE(i);
      std::vector<double> below = x, above = x;
      below[i] -= 1e-5;
      above[i] += 1e-5;
      const double expected = (evaluated(density, above).misfit - evaluated(density, below).misfit) / 2e-5;
      CHECK(within(local.gradient[i], expected, 1e-6 * largest));
    }
  };
  check({{"Nv", {}, Normal{0.4, 0.05}, {}}, {"theta", {}, Normal{0.003, 0.0003}, {}}});
  check({{"Nv", {}, Normal{0.4, 0.05}, {}}});
  check({{"theta", {}, Normal{0.003, 0.0003}, {}}});
}

TEST_CASE("densities of rows add up to the misfit") {
  const Density density(sim::short_protocol(), empty_table({0.05, 0.4, 1.1}, 0.1), {});
  std::vector<double> values(3);
  density.log_densities(density.state(middle), values);
  const double constant = 3.0 * std::log(2.0 * sim::pi);
  CHECK(near(-(values[0] + values[1] + values[2]) - constant, evaluated(density, middle).misfit, 1e-12));
}

TEST_CASE("priors of parameters are checked") {
  const auto with = [](const posterior::ParameterPrior& prior) {
    return [=] { Density(sim::short_protocol(), empty_table({0.05, 0.4, 1.1}, 0.1), {.parameters = {prior}}); };
  };
  check_error(with({"gravity", {}, {}, Fixed(1.0)}), Code::setting_unknown, "gravity");
  check_error(with({"delay", {}, {}, Fixed(9.0)}), Code::setting_out_of_range, "9");
  check_error(with({"Kp", {}, Normal{900.0, -1.0}, {}}), Code::setting_out_of_range, "Kp");
}
