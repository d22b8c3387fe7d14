#include "posterior/frf/comparison.hpp"

#include <cmath>

#include "sim/body_model.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/frf/made_table.hpp"
#include "tests/posterior/frf/third_model.hpp"

using namespace decid;
using namespace decid::test;

namespace {

frf::Table table_of_prior(const sim::Protocol& protocol, double deviation, unsigned number) {
  const frf::Density density(protocol, empty_table(short_frequencies_hz, deviation), {});
  const Random random(6, sim::streams::base_parameters, number);
  return test::table_of(density, state_of_prior(density, random), random);
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

}  // namespace

// Fits without each row; 12 fits.
TEST_CASE("rows left out by importance sampling are those of fits without them" * doctest::test_suite("slow")) {
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

TEST_CASE("the model behind a table predicts it best") {
  const sim::Protocol dec = sim::short_protocol(), dec2015 = with_controller(dec, sim::dec2015());
  const frf::Table table = table_of_prior(dec2015, 0.02, 1);
  const frf::RowsLeftOut of_dec = left_out(dec, table), of_dec2015 = left_out(dec2015, table);
  CHECK(sum(of_dec2015.pointwise) > sum(of_dec.pointwise) + 4.0);
  const std::vector<std::vector<double>> pointwise{of_dec.pointwise, of_dec2015.pointwise};
  const auto compared = posterior::compare_models(pointwise);
  CHECK(compared[1].weight > 0.7);
  CHECK(compared[1].difference == 0.0);
  CHECK(compared[0].standard_error > 0.0);
}
