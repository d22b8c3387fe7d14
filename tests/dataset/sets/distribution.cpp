// Distributions: the figures of their definitions, bins with their edges, and those of a generated data set.
#include "dataset/sets/distribution.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
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
  CHECK(values.least() == -7.0);
  CHECK(values.most() == 3.001);
}

TEST_CASE("mean and deviation do not lose a small spread about a large mean") {
  Distribution values(0.0, 1.0, 1);
  for (const double value : {4.0, 7.0, 13.0, 16.0}) values.add(1e9 + value);
  CHECK(values.mean() == 1e9 + 10.0);
  CHECK(values.stddev() == std::sqrt(22.5));  // nothing on the way is rounded
  Distribution negative(-2.0, 0.0, 1);
  negative.add(-1.5);
  CHECK(negative.least() == -1.5);
  CHECK(negative.most() == -1.5);
}

TEST_CASE("a data set's distributions are those of its trials, before and after enrichment") {
  DatasetReport report;
  const int base = 200, count = 300;
  const Dataset data = generate({tiny_protocol(), count, base, 3}, &report);
  const auto check = [&](const TrialDistributions& found, int trials) {
    CAPTURE(trials);
    for (std::size_t p = 0; p < sim::single_pendulum().parameters.size(); ++p) {
      const sim::ParameterInfo& info = sim::single_pendulum().parameters[p];
      std::vector<double> values;
      std::vector<long long> bins(20, 0);
      for (int i = 0; i < trials; ++i) {
        values.push_back(data.parameters[static_cast<std::size_t>(i)][p]);
        const double place = (values.back() - info.low) / (info.high - info.low);
        ++bins[std::min<std::size_t>(static_cast<std::size_t>(place * 20.0), 19)];
      }
      const double mean = std::accumulate(values.begin(), values.end(), 0.0) / trials;
      double squares = 0.0;
      for (const double value : values) squares += (value - mean) * (value - mean);
      const Distribution& d = found.parameters[p];
      // As many roundings on either side as there are trials.
      const double rounding = trials * std::numeric_limits<double>::epsilon();
      CHECK(near(d.mean(), mean, rounding));
      CHECK(near(d.stddev(), std::sqrt(squares / trials), rounding));
      CHECK(d.least() == *std::ranges::min_element(values));
      CHECK(d.most() == *std::ranges::max_element(values));
      CHECK(std::equal(d.bins().begin(), d.bins().end(), bins.begin(), bins.end()));
      CHECK(d.below() + d.above() == 0);
    }
    double mean = 0.0, most = 0.0;
    long long parents = 0;
    for (int i = 0; i < trials; ++i) {
      const auto [low, high] = std::ranges::minmax(data.trial(i));
      const double width = static_cast<double>(high) - static_cast<double>(low);
      mean += width / trials;
      most = std::max(most, width);
      parents += width > parent_peak_to_peak_rad;
    }
    // The stored sway is rounded to float: half a unit in the last place of 0.09 rad, twice.
    CHECK(std::abs(found.peak_to_peak.mean() - mean) < 8e-9);
    CHECK(std::abs(found.peak_to_peak.most() - most) < 8e-9);
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
