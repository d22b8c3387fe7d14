#include "posterior/frf/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/parallel.hpp"
#include "sim/body_model.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/frf/made_table.hpp"
#include "tests/sim/third_model.hpp"

using namespace decid;
using namespace decid::test;

namespace {

frf::Table table_of_prior(const sim::Protocol& protocol, double stddev, unsigned number) {
  const frf::Density density(protocol, empty_table(short_frequencies_hz, stddev), {});
  const Random random(6, sim::streams::base_parameters, number);
  return test::table_for(density, state_of_prior(density, random), random);
}

frf::RowsLeftOut left_out(const sim::Protocol& protocol, const frf::Table& table) {
  const frf::Density density(protocol, table, {});
  return frf::leave_rows_out(density, frf::fit(density, {}), {});
}

double sum(const std::vector<double>& values) {
  double all = 0.0;
  for (const double value : values) all += value;
  return all;
}

/// A table of a controller from the prior, except for one parameter.
frf::Table table_with(const sim::Protocol& protocol, const char* name, double value, unsigned number) {
  const frf::Density density(protocol, empty_table(short_frequencies_hz, 0.03), {});
  const std::vector<std::string> names = protocol.experiment.body_model->parameters.names();
  const auto place = std::ranges::find(names, name) - names.begin();
  for (unsigned attempt = 0;; ++attempt) {
    const Random random(61, sim::streams::base_parameters, number + attempt * 1'000);
    frf::State state = state_of_prior(density, random);
    state.parameters[static_cast<std::size_t>(place)] = value;
    if (density.is_stable(state)) return test::table_for(density, state, random);
  }
}

struct Preferred {
  int own = 0, clearly_other = 0;  // the other one is better by two standard errors
};

/// Makes this number of tables of a model, and counts those that it predicts better than `other` does.
Preferred count_preferred(const sim::Protocol& own, const sim::Protocol& other, const char* name, double value,
                          int tables) {
  std::vector<int> preferred(static_cast<std::size_t>(tables)), clearly_other(preferred.size());
  parallel_for(tables, [&](int i) {
    const frf::Table table = table_with(own, name, value, static_cast<unsigned>(i));
    const std::vector<std::vector<double>> pointwise{left_out(own, table).pointwise, left_out(other, table).pointwise};
    const auto compared = posterior::compare_models(pointwise);
    const auto place = static_cast<std::size_t>(i);
    preferred[place] = sum(pointwise[0]) > sum(pointwise[1]) ? 1 : 0;
    clearly_other[place] = compared[0].difference < -2.0 * compared[0].standard_error ? 1 : 0;
  });
  return {std::accumulate(preferred.begin(), preferred.end(), 0),
          std::accumulate(clearly_other.begin(), clearly_other.end(), 0)};
}

}  // namespace

// Controllers that differ from `dec` as published ones do; the other parameters are anywhere in their ranges.
TEST_CASE("200 tables: the model behind a table predicts it best" * doctest::test_suite("long")) {
  const sim::Protocol dec = sim::short_protocol();
  const Preferred of_dec2015 = count_preferred(with_model(dec, sim::dec2015()), dec, "G_g", 0.55, 100);
  const Preferred of_ic = count_preferred(with_model(dec, sim::independent_channels()), dec, "W", 0.45, 100);
  MESSAGE("of 100 tables of dec2015 with G_g 0.55, it predicts "
          << of_dec2015.own << " better than dec does; dec is clearly better in " << of_dec2015.clearly_other);
  MESSAGE("of 100 tables of ic with W 0.45, it predicts "
          << of_ic.own << " better than dec does; dec is clearly better in " << of_ic.clearly_other);
  CHECK(of_dec2015.own + of_ic.own >= 180);
  CHECK(of_dec2015.clearly_other + of_ic.clearly_other <= 4);
}

// Fits without each row; 12 fits.
TEST_CASE("rows left out by importance sampling are those of fits without them" * doctest::test_suite("long")) {
  const sim::Protocol protocol = sim::short_protocol();
  frf::Table table = table_of_prior(protocol, 0.05, 2);
  table.rows[3].response *= 1.3;  // the others do not predict it
  const frf::Density density(protocol, table, {});
  const frf::RowsLeftOut found = left_out(protocol, table);
  REQUIRE(found.pointwise.size() == table.rows.size());
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    CAPTURE(row);
    frf::Table others = table;
    others.rows.erase(others.rows.begin() + static_cast<std::ptrdiff_t>(row));
    const frf::Fit without = frf::fit(frf::Density(protocol, others, {}), {.seed = 2});
    double mean = 0.0;
    std::vector<double> values(table.rows.size());
    for (int draw = 0; draw < without.draws(); ++draw) {
      density.log_densities(without.state(draw), values);
      mean += std::exp(values[row]) / without.draws();
    }
    CHECK(within(found.pointwise[row], std::log(mean), 0.35));
  }
}

TEST_CASE("the model behind a table predicts it best" * doctest::test_suite("slow")) {
  const sim::Protocol dec = sim::short_protocol(), dec2015 = with_model(dec, sim::dec2015());
  const frf::Table table = table_of_prior(dec2015, 0.005, 1);
  const frf::RowsLeftOut of_dec = left_out(dec, table), of_dec2015 = left_out(dec2015, table);
  CHECK(sum(of_dec2015.pointwise) > sum(of_dec.pointwise) + 4.0);
  const std::vector<std::vector<double>> pointwise{of_dec.pointwise, of_dec2015.pointwise};
  const auto compared = posterior::compare_models(pointwise);
  CHECK(compared[1].weight > 0.7);
  CHECK(compared[1].difference == 0.0);
  CHECK(compared[0].standard_error > 0.0);
}
