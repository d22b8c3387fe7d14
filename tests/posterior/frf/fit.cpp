#include "posterior/frf/fit.hpp"

#include <algorithm>

#include "base/files/sha256.hpp"
#include "base/text.hpp"
#include "posterior/sampling/diagnostics.hpp"
#include "sim/body_model.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/frf/made_table.hpp"

using namespace decid;
using namespace decid::test;
using frf::Density;

namespace {

frf::State known() {
  return {{900.0, 260.0, 150.0, 120.0, 0.2, 0.002, 0.12}, 1.0, 0.0};
}

/// Fits the response of a known controller, its gains changed by `spoil` at each row, with that standard deviation.
frf::Fit fit_of(double stddev, const frf::Priors& priors, double (*spoil)(std::size_t) = nullptr,
                const frf::SmcSettings& settings = {}) {
  const sim::Protocol protocol = sim::short_protocol();
  const Density made(protocol, empty_table(short_frequencies_hz, 0.02), {});
  frf::Table table = test::table_for(made, known(), Random(4, sim::streams::base_parameters, 0));
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    table.rows[i].stddev = stddev;
    if (spoil) table.rows[i].response *= spoil(i);
  }
  if (stddev == 0.0) table.confidence.clear();
  return frf::fit(Density(protocol, table, priors), settings);
}

double zigzag(std::size_t row) {
  return row % 2 == 0 ? 1.5 : 0.6;
}

}  // namespace

TEST_CASE("draws are states, and known parameters have one value") {
  const frf::Fit found =
      fit_of(0.02, {.gain = 0.0, .error = 0.0, .parameters = {{"Kd", {}, {}, std::optional<double>(260.0)}}});
  for (const int known : {found.gain(), found.error()}) CHECK(found.stddev(known) == 0.0);
  CHECK(found.contraction(found.gain()) == 0.0);
  CHECK(found.correlation(found.gain(), sim::Kp) == 0.0);
  CHECK(found.warnings().empty());
  CHECK(found.draws_for(sim::Kd).front() == 260.0);
  CHECK(found.stddev(sim::Kd) == 0.0);
  CHECK(found.rhat()[sim::Kd] == 1.0);
  CHECK(found.effective_draws()[sim::Kd] == found.draws());
  CHECK(found.contraction(sim::Kd) == 0.0);
  const frf::State last = found.state(found.draws() - 1);
  CHECK(last.parameters[sim::Delay] == found.draws_for(sim::Delay).back());
  CHECK(last.gain == found.draws_for(found.gain()).back());
  CHECK(last.error == found.draws_for(found.error()).back());
  CHECK(found.left() > 0.0);
  CHECK(found.left() < 0.1);
}

TEST_CASE("chains that are apart are a caution, and few draws of chains that agree roughly a note") {
  const auto warning_of = [](const frf::SmcSettings& settings, double low_rhat, double high_rhat) {
    const frf::Fit found = fit_of(0.02, {}, nullptr, settings);
    const double worst = *std::ranges::max_element(found.rhat());
    CAPTURE(worst);
    CHECK(worst > low_rhat);
    CHECK(worst <= high_rhat);
    CHECK_FALSE(found.agreed());
    REQUIRE(found.warnings().size() == 1);
    return found.warnings().front();
  };
  const Warning apart = warning_of({.chains = 4, .thinning = 1, .min_draws = 8, .max_draws = 8}, 1.1, 100.0),
                few = warning_of({.chains = 2, .thinning = 40, .min_draws = 45, .max_draws = 45}, 0.9, 1.1);
  CHECK(apart.code == "chains_disagree");
  CHECK(apart.severity == Severity::caution);
  CHECK(few.code == "few_draws");
  CHECK(few.severity == Severity::info);
}

TEST_CASE("chi-square's tail is that of the tables") {
  CHECK(near(frf::chi_square_beyond(5.991, 2), 0.05, 1e-3));
  CHECK(near(frf::chi_square_beyond(33.924, 22), 0.05, 1e-3));
  CHECK(near(frf::chi_square_beyond(40.289, 22), 0.01, 1e-3));
  CHECK(frf::chi_square_beyond(0.0, 4) == 1.0);
  CHECK(near(frf::chi_square_beyond(1999.333, 2000), 0.5, 1e-4));  // the median, whose density at 0 underflows
  CHECK(frf::chi_square_beyond(2400.0, 2000) < 1e-8);
}

TEST_CASE("the true controller is found, and uninformed parameters keep their priors") {
  const frf::Fit found = fit_of(0.02, {});
  CHECK(found.agreed());
  // The sampler wants 1000 of each coordinate; Nv and theta depend on two.
  CHECK(*std::ranges::min_element(found.effective_draws()) >= 500);
  for (const int q : {int{sim::Nv}, int{sim::Theta}, int{sim::Delay}, found.error()}) {
    CAPTURE(q);
    const posterior::ChainDraws chains = found.chains_for(q);
    REQUIRE(chains.size() == static_cast<std::size_t>(found.chains()));
    CHECK(chains.back().back() == found.draws_for(q).back());
    CHECK(found.rhat()[static_cast<std::size_t>(q)] == posterior::rhat(chains));
    CHECK(found.effective_draws()[static_cast<std::size_t>(q)] == posterior::effective_draws(chains));
  }
  const frf::State truth = known();
  for (int q = 0; q <= static_cast<int>(sim::Delay); ++q) {
    CAPTURE(q);
    // 3.5 deviations: 1 in 2000.
    CHECK(within(found.mean(q), truth.parameters[static_cast<std::size_t>(q)], 3.5 * found.stddev(q)));
    CHECK(found.quantile(q, 0.05) < found.mean(q));
    CHECK(found.quantile(q, 0.95) > found.mean(q));
    CHECK(near(found.prior_stddev(q),
               sim::single_pendulum().parameters[static_cast<std::size_t>(q)].range() / std::sqrt(12.0), 0.15));
  }
  CHECK(found.contraction(sim::Delay) > 0.9);
  CHECK(found.contraction(sim::Kd) > 0.9);
  CHECK(found.contraction(sim::Nv) < 0.7);  // as much passes with more noise and a larger threshold
  CHECK(found.correlation(sim::Nv, sim::Theta) > 0.5);
  CHECK(near(found.correlation(sim::Nv, sim::Nv), 1.0, 1e-12));
  CHECK(found.misfit().degrees_of_freedom == 22);
  CHECK(found.misfit().p_value > 0.01);
  CHECK(found.warnings().empty());
  REQUIRE(found.predicted().size() == 11);
  for (const frf::Predicted& row : found.predicted()) {
    const double gain = std::abs(row.response);
    CHECK(row.gain_low < gain);
    CHECK(row.gain_high > gain);
    CHECK(row.phase_low_deg < row.phase_deg);
    CHECK(row.phase_high_deg > row.phase_deg);
    CHECK(row.distance < 4.0);
  }
}

TEST_CASE("a table that no controller explains gives a warning and wider intervals") {
  const frf::Fit good = fit_of(0.02, {}), bad = fit_of(0.02, {}, zigzag);
  CHECK(bad.misfit().p_value < 1e-6);
  REQUIRE(bad.warnings().size() == 2);
  CHECK(bad.warnings()[0].code == "no_controller");
  CHECK(bad.warnings()[0].severity == Severity::invalid);
  CHECK(bad.warnings()[1].code == "table_unexplained");
  CHECK_FALSE(bad.explained());
  CHECK(good.explained());
  CHECK(bad.mean(bad.error()) > 0.2);
  CHECK(bad.stddev(sim::Delay) > 2.0 * good.stddev(sim::Delay));
  const frf::Fit sure = fit_of(0.02, {.error = 0.0}, zigzag);
  REQUIRE_FALSE(sure.warnings().empty());
  CHECK(contains(sure.warnings().back().text, "too narrow"));
}

TEST_CASE("without confidence the table's errors are inferred, and large ones give a warning") {
  const frf::Fit good = fit_of(0.0, {});
  CHECK(std::isnan(good.misfit().p_value));
  CHECK(good.mean(good.error()) > 0.005);
  CHECK(good.mean(good.error()) < 0.08);
  CHECK(good.warnings().empty());
  const frf::Fit bad = fit_of(0.0, {}, zigzag);
  CHECK(bad.mean(bad.error()) > 0.25);
  REQUIRE(bad.warnings().size() == 2);
  CHECK(bad.warnings()[0].code == "no_controller");
  CHECK(bad.warnings()[1].code == "response_unexplained");
  // Both state the same part, and the first names the columns that tell noise from another controller.
  const std::string left = format("%.0f%% of the response", 100.0 * bad.left());
  for (const Warning& warning : bad.warnings()) CHECK(contains(warning.text, left));
  for (const char* column : {"sd", "ci95", "coherence", "cycles"}) CHECK(contains(bad.warnings()[0].text, column));
}

TEST_CASE("the draws have the same bits everywhere" * doctest::test_suite("golden")) {
  const frf::Fit found = fit_of(0.02, {});
  std::string bytes;
  for (int q = 0; q <= found.error(); ++q)
    bytes.append(reinterpret_cast<const char*>(found.draws_for(q).data()), found.draws_for(q).size() * sizeof(double));
  CHECK(sha256(bytes) == "9e2819aa15e9e87881437715a02d07996359d997aa14447868dedd2b950dc424");
}
