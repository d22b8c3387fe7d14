#include "posterior/frf/fit.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

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

/// The response of that controller with a standard deviation of 0.02.
frf::Table table_of_known() {
  const Density made(sim::short_protocol(), empty_table(short_frequencies_hz, 0.02), {});
  return test::table_for(made, known(), Random(4, sim::streams::base_parameters, 0));
}

/// Fits the response of a known controller, its gains changed by `spoil` at each row, with that standard deviation.
frf::Fit fit_of(double stddev, const frf::Priors& priors, double (*spoil)(std::size_t) = nullptr,
                const frf::SmcSettings& settings = {}) {
  const sim::Protocol protocol = sim::short_protocol();
  frf::Table table = table_of_known();
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

bool has(const frf::Fit& found, std::string_view code) {
  return std::ranges::count(found.warnings(), code, &Warning::code) > 0;
}

using Prior = posterior::ParameterPrior;

using Normals = std::vector<std::pair<std::size_t, Prior::Normal>>;  // by parameter

/// Fixes the known controller's parameters except these, which have normal priors.
frf::Priors normal_priors(const Normals& normals) {
  frf::Priors priors{.gain = 0.0, .error = 0.0};
  const sim::ParameterTable& table = sim::single_pendulum().parameters;
  for (std::size_t p = 0; p < table.size(); ++p) {
    const auto normal = std::ranges::find(normals, p, [](const auto& pair) { return pair.first; });
    Prior& prior = priors.parameters.emplace_back(Prior{.name = table[p].name});
    if (normal != normals.end())
      prior.normal = normal->second;
    else
      prior.fixed = known().parameters[p];
  }
  return priors;
}

struct Moments {
  double mean, stddev;
};

/// The posterior's moments of each normal parameter on a grid within 12 of the prior's standard deviations.
std::vector<Moments> on_grid(const Density& density, const Normals& normals, int side) {
  frf::State state = known();
  std::vector<double> rows(density.table().rows.size());
  std::vector<std::vector<double>> points;
  std::vector<double> logarithms, point(normals.size());
  int nodes = 1;
  for (std::size_t k = 0; k < normals.size(); ++k) nodes *= side;
  for (int node = 0; node < nodes; ++node) {
    double sum = 0.0;
    bool is_inside = true;
    for (std::size_t k = 0, rest = static_cast<std::size_t>(node); k < normals.size();
         ++k, rest /= static_cast<std::size_t>(side)) {
      const auto& [parameter, normal] = normals[k];
      const double z = 12.0 * (2.0 * (static_cast<double>(rest % static_cast<std::size_t>(side)) + 0.5) / side - 1.0);
      state.parameters[parameter] = point[k] = normal.mean + z * normal.sd;
      is_inside =
          is_inside && point[k] >= density.ranges()[parameter].low && point[k] <= density.ranges()[parameter].high;
      sum -= 0.5 * z * z;
    }
    if (!is_inside || !density.is_stable(state)) continue;
    density.log_densities(state, rows);
    for (const double value : rows) sum += value;
    points.push_back(point);
    logarithms.push_back(sum);
  }
  const double largest = *std::ranges::max_element(logarithms);
  std::vector<Moments> moments;
  for (std::size_t k = 0; k < normals.size(); ++k) {
    double whole = 0.0, mean = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double weight = std::exp(logarithms[i] - largest);
      whole += weight, mean += weight * points[i][k], squares += weight * points[i][k] * points[i][k];
    }
    mean /= whole;
    moments.push_back({mean, std::sqrt(squares / whole - mean * mean)});
  }
  return moments;
}

/// Checks the draws against the grid: 4.5 standard errors of 1000 draws.
void check_on_grid(const Normals& normals, int side, double distance, bool contradicted) {
  const Density density(sim::short_protocol(), table_of_known(), normal_priors(normals));
  const frf::Fit found = frf::fit(density, {});
  CHECK(found.agreed());
  CHECK(has(found, "prior_contradicted") == contradicted);
  const std::vector<Moments> grid = on_grid(density, normals, side);
  for (std::size_t k = 0; k < normals.size(); ++k) {
    const int quantity = static_cast<int>(normals[k].first);
    CAPTURE(quantity);
    CHECK(within(found.mean(quantity), grid[k].mean, 0.15 * grid[k].stddev));
    CHECK(near(found.stddev(quantity), grid[k].stddev, 0.12));
  }
  const Prior::Normal& first = normals.front().second;
  CHECK(std::abs(grid.front().mean - first.mean) > distance * first.sd);
}

}  // namespace

TEST_CASE("normal priors of the dead band reach beyond 3 of their standard deviations, as on a grid") {
  check_on_grid({{sim::Theta, {0.003, 0.00025}}, {sim::Nv, {0.2, 0.02}}}, 240, 3.5, false);
}

TEST_CASE("normal priors reach beyond 8 of their standard deviations, as on a grid, with a caution") {
  check_on_grid({{sim::Kp, {600.0, 20.0}}}, 2000, 9.0, true);
  check_on_grid({{sim::Kp, {1200.0, 20.0}}}, 2000, 9.0, true);
}

TEST_CASE("confidences that are far too large are a caution") {
  const frf::Fit found = fit_of(1.0, {});
  CHECK(found.misfit().p_value > 0.999);
  REQUIRE(found.warnings().size() == 1);
  CHECK(found.warnings()[0].code == "confidence_too_large");
  CHECK(found.warnings()[0].severity == Severity::caution);
}

TEST_CASE("the priors that are given are named if no controller within them explains the table") {
  const auto text_of = [](const frf::Priors& priors, std::string_view code) {
    const frf::Fit found = fit_of(0.02, priors);
    const auto warning = std::ranges::find(found.warnings(), code, &Warning::code);
    REQUIRE(warning != found.warnings().end());
    return warning->text;
  };
  for (const Prior& prior :
       {Prior{.name = "delay", .fixed = 0.22}, Prior{.name = "delay", .range = Prior::Range{0.2, 0.24}},
        Prior{.name = "delay", .normal = Prior::Normal{0.22, 0.001}}})
    for (const char* code : {"no_controller", "table_unexplained"}) {
      CAPTURE(code);
      CHECK(contains(text_of({.parameters = {prior}}, code), "given ranges, priors and fixed values"));
    }
  const frf::Fit spoilt = fit_of(0.02, {}, zigzag);
  for (const Warning& warning : spoilt.warnings()) CHECK_FALSE(contains(warning.text, "given"));
}

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
