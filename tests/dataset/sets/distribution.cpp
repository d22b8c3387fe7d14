// Distributions: the figures of their definitions, bins with their edges, and those of a generated data set.
#include "dataset/sets/distribution.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "dataset/sets/dataset.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/tiny_protocol.hpp"

using namespace decid;
using namespace decid::dataset;
using namespace decid::test;

TEST_CASE("a distribution counts each value in its bin, edges in the upper one, the last edge in the last") {
  Distribution values(1.0, 3.0, 4);
  CHECK(values.count() == 0);
  CHECK(values.mean() == 0.0);
  CHECK(values.stddev() == 0.0);
  for (const double value : {1.0, 1.25, 1.5, 2.0, 2.9, 3.0, 0.999, 3.001, -7.0}) values.add(value);
  const std::vector<long long> expected{2, 1, 1, 2};
  CHECK(std::equal(values.bins().begin(), values.bins().end(), expected.begin(), expected.end()));
  CHECK(values.below() == 2);
  CHECK(values.above() == 1);
  CHECK(values.count() == 9);
  CHECK(values.min() == -7.0);
  CHECK(values.max() == 3.001);
}

TEST_CASE("mean and deviation do not lose a small spread about a large mean") {
  Distribution values(0.0, 1.0, 1);
  for (const double value : {4.0, 7.0, 13.0, 16.0}) values.add(1e9 + value);
  CHECK(values.mean() == 1e9 + 10.0);
  CHECK(values.stddev() == std::sqrt(22.5));  // nothing on the way is rounded
  Distribution negative(-2.0, 0.0, 1);
  negative.add(-1.5);
  CHECK(negative.min() == -1.5);
  CHECK(negative.max() == -1.5);
}

TEST_CASE("a data set's distributions are those of its trials, before and after enrichment") {
  DatasetReport report;
  const int base = 200, count = 300;
  const Dataset data = generate({tiny_protocol(), count, base, 3}, &report);
  const auto check = [&](const TrialDistributions& found, int trials) {
    CAPTURE(trials);
    TrialDistributions expected(sim::single_pendulum().parameters);
    long long parents = 0;
    for (int i = 0; i < trials; ++i) {
      const auto [low, high] = std::ranges::minmax(data.trial(i));
      const double width = static_cast<double>(high) - static_cast<double>(low);
      expected.add(data.parameters[static_cast<std::size_t>(i)], width);
      parents += width > parent_peak_to_peak_rad;
    }
    REQUIRE(found.parameters.size() == expected.parameters.size());
    for (std::size_t p = 0; p < expected.parameters.size(); ++p) {
      const Distribution &d = found.parameters[p], &e = expected.parameters[p];
      CHECK(d.mean() == e.mean());
      CHECK(d.stddev() == e.stddev());
      CHECK(d.min() == e.min());
      CHECK(d.max() == e.max());
      CHECK(std::ranges::equal(d.bins(), e.bins()));
      CHECK(d.below() + d.above() == 0);
    }
    // The stored sway is rounded to float: half a unit in the last place of 0.09 rad, twice.
    CHECK(std::abs(found.peak_to_peak.mean() - expected.peak_to_peak.mean()) < 8e-9);
    CHECK(std::abs(found.peak_to_peak.max() - expected.peak_to_peak.max()) < 8e-9);
    CHECK(found.peak_to_peak.count() == trials);
    CHECK(found.peak_to_peak.above() == 0);
    // 0.05 rad is the edge between bins 9 and 10.
    const auto bins = found.peak_to_peak.bins();
    CHECK(std::accumulate(bins.begin() + 10, bins.end(), 0LL) == parents);
  };
  check(report.base, base);
  check(report.all, count);
  CHECK(report.parents > 3);
}
