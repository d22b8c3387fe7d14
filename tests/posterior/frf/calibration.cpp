// Do posteriors of frequency responses keep what they promise? Simulation-based calibration: of tables made from the
// prior, the true values' ranks among the draws are uniform (Talts et al., arXiv:1804.06788).
#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "base/math/statistics.hpp"
#include "base/parallel.hpp"
#include "posterior/frf/fit.hpp"
#include "sim/body_model.hpp"
#include "sim/streams.hpp"
#include "tests/posterior/frf/made_table.hpp"

using namespace decid;
using namespace decid::test;

namespace {

// Sampled tables per case. The short form guards the sampler in every check, the long form in tools/check --long.
constexpr int short_form = 20, long_form = 200;
// Kolmogorov's distance times sqrt(n) exceeds 1.95 with a probability of 1 in 1000; 8 to 13 quantities in each case, so
// that a right sampler fails a case with 1 in 80 to 110 of all seeds. The short form has the same false-alarm rate; it
// detects errors that are sqrt(10) times as large.
constexpr double max_distance = 1.95;

struct Calibration {
  std::vector<std::vector<double>> ranks;                      // by quantity
  std::vector<std::vector<double>> squared_errors, variances;  // the same, stated variances
  std::vector<double> rhat, p_values, errors;
};

Calibration calibrate(const sim::BodyModel& model, double confidence, int tables) {
  sim::Protocol protocol = sim::short_protocol();
  protocol.experiment.body_model = &model;
  const frf::Density made(protocol, empty_table(short_frequencies_hz, confidence), {});
  frf::SmcSettings settings;
  settings.effective_draws = 200;  // ranks are known to 0.035 or better, an eighth of their own spread
  settings.max_rhat = 1.05;
  Calibration all;
  for (auto* values : {&all.ranks, &all.squared_errors, &all.variances})
    values->assign(static_cast<std::size_t>(made.quantities()), std::vector<double>(static_cast<std::size_t>(tables)));
  all.rhat.resize(static_cast<std::size_t>(tables));
  all.p_values.resize(all.rhat.size());
  all.errors.resize(all.rhat.size());
  parallel_for(tables, [&](int i) {
    const auto number = static_cast<std::size_t>(i);
    const Random random(31, sim::streams::base_parameters, number);
    const frf::State truth = state_of_prior(made, random);
    const frf::Density density(protocol, table_for(made, truth, random), {});
    const frf::Fit found = frf::fit(density, settings);
    for (int q = 0; q < made.quantities(); ++q) {
      const std::vector<double>& draws = found.draws_for(q);
      const double value = density.value(truth, q);
      const auto below = std::ranges::count_if(draws, [&](double draw) { return draw < value; });
      const auto equal = std::ranges::count(draws, value);
      const auto place = static_cast<std::size_t>(q);
      all.ranks[place][number] =
          (static_cast<double>(below) + 0.5 * static_cast<double>(equal)) / static_cast<double>(draws.size());
      const double error = mean(draws) - value, deviation = stddev(draws);
      all.squared_errors[place][number] = error * error;
      all.variances[place][number] = deviation * deviation;
    }
    all.rhat[number] = *std::ranges::max_element(found.rhat());
    all.p_values[number] = found.misfit().p_value;
    all.errors[number] = truth.error;
  });
  return all;
}

/// Kolmogorov's, from uniform, times the root of their number.
double distance(std::vector<double> ranks) {
  std::sort(ranks.begin(), ranks.end());
  const auto count = static_cast<double>(ranks.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < ranks.size(); ++i)
    largest =
        std::max({largest, static_cast<double>(i + 1) / count - ranks[i], ranks[i] - static_cast<double>(i) / count});
  return largest * std::sqrt(count);
}

double share_covered(const std::vector<double>& ranks) {
  return static_cast<double>(std::ranges::count_if(ranks, [](double rank) { return rank > 0.05 && rank < 0.95; })) /
         static_cast<double>(ranks.size());
}

/// max_apart: the largest fraction of tables with an R-hat above 1.1.
void check(const sim::BodyModel& model, const Calibration& found, double max_apart) {
  const auto tables = static_cast<int>(found.rhat.size());
  std::vector<std::string> names = model.parameters.names();
  names.insert(names.end(), {"gain", "error"});
  for (std::size_t q = 0; q < names.size(); ++q) {
    const auto& ranks = found.ranks[q];
    if (std::ranges::all_of(ranks, [](double rank) { return rank == 0.5; })) continue;  // fixed
    CAPTURE(names[q]);
    const double off = distance(ranks), covered = share_covered(ranks);
    MESSAGE(model.name << ", " << names[q] << ": distance " << off << ", in the 90 % interval " << covered);
    CHECK(off < max_distance);
    CHECK(covered > 0.9 - 3.1 * std::sqrt(0.09 / tables));
    if (q >= model.parameters.size()) continue;
    const double width = model.parameters[q].high - model.parameters[q].low, variance = width * width / 12.0;
    MESSAGE("squared error " << mean(found.squared_errors[q]) / variance << ", stated "
                             << mean(found.variances[q]) / variance << " of the range's variance");
  }
  const auto disagreeing = std::ranges::count_if(found.rhat, [](double value) { return value > 1.1; });
  MESSAGE(disagreeing << " of " << tables << " with an R-hat above 1.1, largest "
                      << *std::ranges::max_element(found.rhat));
  CHECK(static_cast<double>(disagreeing) <= std::max(1.0, max_apart * tables));
}

void check_with_confidence(const sim::BodyModel& model, int tables) {
  const Calibration found = calibrate(model, 0.03, tables);
  check(model, found, 0.05);  // long ridges of dec2015: 7 of 200 tables
  // Warned of are those that err beyond their confidence; of the others, a few in a hundred at most.
  int small = 0, alarms = 0, false_alarms = 0;
  for (std::size_t i = 0; i < found.errors.size(); ++i) {
    const bool is_small = found.errors[i] < 0.01, warned = found.p_values[i] < 0.01;
    small += is_small ? 1 : 0;
    alarms += warned ? 1 : 0;
    false_alarms += is_small && warned ? 1 : 0;
  }
  MESSAGE("warned of " << alarms << " of " << tables << " tables, of " << false_alarms << " of " << small
                       << " that err by less than 1 % beyond their confidence");
  // Three of seven tables, or 11 of 100, are warned of with a probability of 2 in 1000, if 4 in 100 are.
  CHECK(false_alarms <= std::max(2, small / 10));
}

}  // namespace

TEST_CASE("ranks of known values among the draws are uniform, with confidence" * doctest::test_suite("slow")) {
  check_with_confidence(sim::single_pendulum(), short_form);
}

TEST_CASE("200 tables: ranks are uniform, with confidence" * doctest::test_suite("long")) {
  for (const sim::BodyModel* model : {&sim::single_pendulum(), &sim::dec2015(), &sim::independent_channels()})
    check_with_confidence(*model, long_form);
}

TEST_CASE("200 tables: ranks are uniform, without confidence" * doctest::test_suite("long")) {
  for (const sim::BodyModel* model : {&sim::single_pendulum(), &sim::dec2015(), &sim::independent_channels()})
    check(*model, calibrate(*model, 0.0, long_form), 0.12);  // and 16, if the tables' error is inferred too
}
