// The field's least squares against the posterior's mode, where the noise makes them comparable.
#include "posterior/frf/least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "posterior/frf/fit.hpp"
#include "sim/body_model.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/frf/made_table.hpp"
#include "tests/sim/third_model.hpp"

using namespace decid;
using namespace decid::test;

namespace {

constexpr double noise = 0.002;  // of the response, at the mean weight

/// A table of a controller of the prior, with the noise under which the least squares are the likelihood: its standard
/// deviation is the response's size over the root of the row's weight.
frf::Table made(const sim::Protocol& protocol, const Random& random) {
  frf::Table table = empty_table(short_frequencies_hz, 0.1);
  const frf::Density density(protocol, table, {.gain = 0.0, .error = 0.0});
  const frf::State state = state_of_prior(density, random);
  std::vector<sim::Complex> responses(table.rows.size());
  density.respond(state, responses);
  const std::vector<double> weights = frf::log_ratio_weights(table);
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const double sd = noise * std::abs(responses[i]) / std::sqrt(weights[i]);
    table.rows[i].response =
        responses[i] + sd * sim::Complex(random.normal(2'000'000 + 2 * i), random.normal(2'000'001 + 2 * i));
    table.rows[i].stddev = noise * std::abs(table.rows[i].response) / std::sqrt(weights[i]);
  }
  return table;
}

/// The maximum of the density in its coordinates, in which the priors of all parameters are uniform.
struct Mode {
  frf::State state;
  double passing_gain;
  std::vector<sim::Complex> responses;

  explicit Mode(const frf::Density& density) : responses(density.table().rows.size()) {
    const auto evaluate = [&](std::span<const double> x, frf::Local& local) { density.evaluate(x, local); };
    state = density.state(frf::minimise(density.size(), density.uniform(), evaluate, {}).x);
    const sim::Coefficients c = density.model().protocol().family().coefficients(state.parameters);
    passing_gain = density.model().passing_gain(c[sim::Coefficient::nv], c[sim::Coefficient::theta]);
    density.respond(state, responses);
  }
};

}  // namespace

TEST_CASE("rows weigh by coherence over frequency") {
  frf::Table table = empty_table({0.1, 0.2, 0.5}, 0.1);
  std::vector<double> weights = frf::log_ratio_weights(table);
  CHECK(near(weights[0] / weights[1], 2.0, 1e-12));
  CHECK(near(weights[0] + weights[1] + weights[2], 3.0, 1e-12));
  table.rows[0].coherence = 0.4;
  table.rows[1].coherence = 0.8;
  weights = frf::log_ratio_weights(table);
  CHECK(near(weights[0] / weights[1], 1.0, 1e-12));
}

TEST_CASE("the misfit is half the weighted squares of the log ratios") {
  const frf::Density density(sim::short_protocol(),
                             made(sim::short_protocol(), Random(8, sim::streams::base_parameters, 1)), {});
  const frf::PointEstimate found = frf::fit_log_ratio(density, {});
  const std::vector<double> weights = frf::log_ratio_weights(density.table());
  double sum = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i)
    sum += 0.5 * weights[i] * std::norm(std::log(found.responses[i] / density.table().rows[i].response));
  CHECK(near(found.misfit, sum, 1e-9));
  CHECK(found.left < 3.0 * noise);
  CHECK(found.state.gain == 1.0);
  CHECK(found.agreeing >= 1);
}

// 20 frequency responses of each model. `dec2015` has eleven parameters for 22 numbers, and its tilt gain acts only as
// a product with the passing gain, so that many parameters have the same response: there the responses agree.
TEST_CASE("the posterior's mode is the least squares' where their noise is the same" * doctest::test_suite("slow")) {
  for (const sim::BodyModel* model : {&sim::single_pendulum(), &sim::independent_channels(), &sim::dec2015()}) {
    const sim::Protocol protocol = with_model(sim::short_protocol(), *model);
    double worst = 0.0, apart = 0.0;
    for (std::uint64_t i = 0; i < 20; ++i) {
      const frf::Table table = made(protocol, Random(12, sim::streams::base_parameters, i));
      const frf::Density density(protocol, table, {.gain = 0.0, .error = 0.0});
      const frf::PointEstimate squares = frf::fit_log_ratio(density, {});
      const Mode mode(density);
      for (std::size_t p = 0; p < model->parameters.size(); ++p) {
        const std::string& name = model->parameters[p].name;
        if (name == "Nv" || name == "theta") continue;
        worst = std::max(worst,
                         std::abs(squares.state.parameters[p] - mode.state.parameters[p]) / mode.state.parameters[p]);
      }
      worst = std::max(worst, std::abs(squares.passing_gain - mode.passing_gain));
      for (std::size_t row = 0; row < table.rows.size(); ++row)
        apart = std::max(apart, std::abs(squares.responses[row] / mode.responses[row] - 1.0));
    }
    MESSAGE(model->name << ": parameters within " << worst << ", responses within " << apart);
    if (model != &sim::dec2015()) CHECK(worst < 0.01);
    CHECK(apart < 0.001);
  }
}

TEST_CASE("no draw has more density than the mode") {
  const frf::Table table = made(sim::short_protocol(), Random(12, sim::streams::base_parameters, 3));
  const frf::Density density(sim::short_protocol(), table, {.gain = 0.0, .error = 0.0});
  const Mode mode(density);
  const frf::Fit found = frf::fit(density, {});
  const double least = 0.5 * density.chi_square(mode.state, 0.0);
  for (int draw = 0; draw < found.draws(); draw += 7)
    CHECK(0.5 * density.chi_square(found.state(draw), 0.0) > least - 1e-3);
}

TEST_CASE("a table that no controller explains is a warning of the least squares too") {
  frf::Table table = made(sim::short_protocol(), Random(12, sim::streams::base_parameters, 3));
  const auto warnings_of = [&] {
    return frf::fit_log_ratio(frf::Density(sim::short_protocol(), table, {}), {}).warnings;
  };
  CHECK(warnings_of().empty());
  for (std::size_t row = 0; row < table.rows.size(); ++row) table.rows[row].response *= row % 2 == 0 ? 1.5 : 0.6;
  REQUIRE(warnings_of().size() == 1);
  CHECK(warnings_of()[0].code == "no_controller");
  CHECK(warnings_of()[0].severity == Severity::invalid);
  // A table whose confidence allows for the distance is explained.
  table.confidence = "sd";
  for (frf::Row& row : table.rows) row.stddev = 1.0;
  CHECK(warnings_of().empty());
}

TEST_CASE("parameters at an end of their range are reported") {
  const frf::Table table = made(sim::short_protocol(), Random(12, sim::streams::base_parameters, 3));
  const frf::Priors priors{.parameters = {{.name = "delay", .range = posterior::ParameterPrior::Range{0.2, 0.24}},
                                          {.name = "Kd", .range = {}, .normal = {}, .fixed = 250.0}}};
  const frf::Density density(sim::short_protocol(), table, priors);
  const frf::PointEstimate found = frf::fit_log_ratio(density, {});
  CHECK(found.at_end[sim::Delay]);
  CHECK_FALSE(found.at_end[sim::Kd]);
  CHECK(found.state.parameters[sim::Kd] == 250.0);
}

TEST_CASE("the least squares use normal priors as uniform") {
  const frf::Table table = made(sim::short_protocol(), Random(12, sim::streams::base_parameters, 3));
  const auto found = [&](const frf::Priors& priors) {
    return frf::fit_log_ratio(frf::Density(sim::short_protocol(), table, priors), {}).state.parameters;
  };
  const sim::Parameters plain = found({}),
                        normal = found(
                            {.parameters = {{.name = "Kp", .normal = posterior::ParameterPrior::Normal{800.0, 5.0}}}});
  for (std::size_t p = 0; p < plain.size(); ++p) CHECK(plain[p] == normal[p]);
}
