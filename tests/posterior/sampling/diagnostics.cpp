// Diagnostics on chains whose convergence is known.
#include "posterior/sampling/diagnostics.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/math/random.hpp"
#include "posterior/streams.hpp"
#include "tests/near.hpp"

using namespace decid;
using namespace decid::posterior;
using decid::test::near;

namespace {

/// First-order autoregression of deviation 1: its draws are worth (1 - a) / (1 + a) of independent ones.
ChainDraws autoregression(double a, int chains, int draws) {
  ChainDraws all;
  for (int chain = 0; chain < chains; ++chain) {
    const Random random(6, posterior::streams::chains, static_cast<std::uint64_t>(chain));
    double value = random.normal(0);
    std::vector<double>& values = all.emplace_back();
    for (int i = 0; i < draws; ++i) {
      value = a * value + std::sqrt(1.0 - a * a) * random.normal(static_cast<std::uint64_t>(i) + 1);
      values.push_back(value);
    }
  }
  return all;
}

}  // namespace

TEST_CASE("effective draws of the mean and of the tails: known of an autoregression, fewer where tails stick") {
  const ChainDraws independent = autoregression(0.0, 8, 1000), slow = autoregression(0.8, 8, 1000);
  CHECK(near(mean_effective_draws(independent), 8000.0, 0.1));
  CHECK(near(mean_effective_draws(slow), 8000.0 / 9.0, 0.15));  // (1 - 0.8) / (1 + 0.8)
  CHECK(near(tail_effective_draws(independent), 8000.0, 0.15));
  CHECK(tail_effective_draws(slow) < 0.5 * tail_effective_draws(independent));
  ChainDraws sticky = independent;  // one chain stays in the tail for a tenth of its time
  for (std::size_t i = 100; i < 200; ++i) sticky[0][i] = 5.0;
  CHECK(tail_effective_draws(sticky) < 0.5 * tail_effective_draws(independent));
  for (const double end : {-5.0, 5.0}) {  // one of eight chains stays at either end: more than 5% are the limit itself
    ChainDraws stuck = independent;
    std::ranges::fill(stuck[0], end);
    CHECK(tail_effective_draws(stuck) < 20.0);
  }
  CHECK(tail_effective_draws(ChainDraws(4, std::vector<double>(10, 1.0))) == 40.0);
}

TEST_CASE("diagnostics: draws that are not finite are no draws") {
  ChainDraws chains = autoregression(0.0, 8, 40);
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    chains[3][7] = value;
    CHECK(rhat(chains) == std::numeric_limits<double>::infinity());
    CHECK(effective_draws(chains) == 0.0);
    CHECK(mean_effective_draws(chains) == 0.0);
    CHECK(tail_effective_draws(chains) == 0.0);
  }
}

TEST_CASE("rhat: 1 for chains that agree, above for those that differ in place, spread or trend") {
  const ChainDraws good = autoregression(0.0, 8, 400);
  CHECK(rhat(good) < 1.01);
  ChainDraws moved = good, wide = good, trend = good;
  for (double& value : moved[3]) value += 2.0;
  for (double& value : wide[2]) value *= 4.0;
  for (std::vector<double>& chain : trend)
    for (std::size_t i = 0; i < chain.size(); ++i) chain[i] += 0.01 * static_cast<double>(i);
  CHECK(rhat(moved) > 1.1);
  CHECK(rhat(wide) > 1.02);
  CHECK(rhat(trend) > 1.3);
  // Values of any distribution: ranks alone count.
  ChainDraws heavy = good;
  for (std::vector<double>& chain : heavy)
    for (double& value : chain) value = std::exp(5.0 * value);
  CHECK(near(rhat(heavy), rhat(good), 0.01));
}

TEST_CASE("rhat: chains that stand still") {
  CHECK(rhat({{1, 1, 1, 1}, {1, 1, 1, 1}}) == 1.0);
  CHECK(rhat({{1, 1, 1, 1}, {2, 2, 2, 2}}) == std::numeric_limits<double>::infinity());
}

TEST_CASE("effective_draws: as theory has it for autoregressions") {
  constexpr int chains = 8, draws = 2000;
  for (const double a : {0.0, 0.5, 0.9}) {
    const double expected = chains * draws * (1.0 - a) / (1.0 + a);
    CHECK(near(effective_draws(autoregression(a, chains, draws)), expected, 0.15));
  }
  // Chains that differ are worth little, however long.
  ChainDraws apart = autoregression(0.0, 8, 400);
  for (double& value : apart[0]) value += 10.0;
  CHECK(effective_draws(apart) < 100.0);
}

TEST_CASE(
    "rhat, effective_draws: figures of a few draws, by the formulas of Vehtari et al. 2021 written again in Python") {
  // Three chains of twelve: with so few, every divisor counts. The figures: diagnostics.py.
  ChainDraws mixed, slow;
  for (int c = 0; c < 3; ++c) {
    mixed.emplace_back();
    slow.emplace_back();
    for (int i = 0; i < 12; ++i) {
      mixed.back().push_back((7 * i * i + 3 * i + 5 * c * c + 11 * c) % 29 / 4.0 + 0.3 * c * (i % 3));
      slow.back().push_back((c * 5 + i * (2 + c)) % 31 + 3.0 * i);
    }
  }
  CHECK(near(rhat(mixed), 1.0233572392476087, 1e-12));
  CHECK(near(effective_draws(mixed), 47.935836103734765, 1e-12));
  CHECK(near(rhat(slow), 1.3941868407090134, 1e-12));
  CHECK(near(effective_draws(slow), 6.74049223467292, 1e-12));
}

TEST_CASE("energy_fraction: 2 for independent energies, small for a slow walk") {
  CHECK(near(energy_fraction(autoregression(0.0, 4, 4000)), 2.0, 0.1));
  CHECK(energy_fraction(autoregression(0.98, 4, 2000)) < 0.1);
  ChainDraws stuck = autoregression(0.0, 4, 100);
  std::ranges::fill(stuck[1], 5.0);
  CHECK(std::isnan(energy_fraction(stuck)));
  CHECK(std::isnan(energy_fraction({{5.0, 5.0, 5.0, 5.0}})));
}
