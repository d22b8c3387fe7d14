// Several trials of one person as a target of chains: their metric, their density, their draws.
#include "posterior/sampling/target.hpp"

#include <cmath>
#include <numeric>
#include <utility>

#include "base/math/cholesky.hpp"
#include "posterior/posterior.hpp"
#include "posterior/sampling/sampler.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/sampling/prior_draws.hpp"
#include "tests/posterior/sampling/quick.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

namespace {

constexpr std::size_t count = 7;  // parameters
using Matrix = std::vector<std::vector<double>>;

/// Two trials, the second with a vestibular threshold of its own.
struct Pair {
  sim::Protocol protocol = sines_protocol();
  Density density{protocol, {}};
  std::array<Observation, 2> observations{density.observe(recorded(protocol, some_parameters(), 0.02, 0)),
                                          density.observe(recorded(protocol, some_parameters(), 0.02, 1))};
  std::size_t size = static_cast<std::size_t>(density.size()), own = size - count;

  static std::vector<std::size_t> common(std::size_t threshold) {
    std::vector<std::size_t> numbers(count);
    std::iota(numbers.begin(), numbers.end(), std::size_t{0});
    numbers[sim::Theta] = threshold;
    return numbers;
  }
  Target target() const {
    return Target({{&density, &observations[0], common(sim::Theta)}, {&density, &observations[1], common(count)}});
  }
  std::vector<double> standard_normal(std::uint64_t item, std::size_t values) const {
    std::vector<double> x(values);
    Random(7, sim::streams::sensor_noise, item).fill_normal(x, 1);
    return x;
  }
  /// An information about a trial: a prior of 1, and random rows.
  std::vector<double> information(std::uint64_t item) const {
    std::vector<double> matrix(triangle(size), 0.0);
    for (std::uint64_t k = 0; k < 12; ++k) {
      const std::vector<double> row = standard_normal(100 * item + k, size);
      for (std::size_t i = 0; i < size; ++i)
        for (std::size_t j = 0; j <= i; ++j) matrix[triangle(i) + j] += row[i] * row[j];
    }
    for (std::size_t i = 0; i < size; ++i) matrix[triangle(i) + i] += 1.0;
    return matrix;
  }
};

}  // namespace

TEST_CASE_FIXTURE(Pair, "Target: one trial has its density's rows, and no common unknowns") {
  const Target one(density, observations[0]);
  CHECK_FALSE(one.joint());
  CHECK(one.rows(0) == size);
  CHECK(one.globals() == static_cast<std::size_t>(density.globals()));
  const Target two = target();
  CHECK(two.commons() == count + 1);
  CHECK(two.rows(1) == own + count + 1);
  CHECK(two.globals() == 2 * Density::others + count + 1);
}

TEST_CASE_FIXTURE(Pair, "Target: rows and coordinates convert into each other") {
  const Target two = target();
  for (std::size_t t = 0; t < 2; ++t) {
    const std::vector<double> x = standard_normal(t, size * lanes);
    std::vector<double> rows(two.rows(t) * lanes), back(x.size());
    two.to_rows(t, x, rows);
    two.from_rows(t, rows, back);
    CHECK(back == x);
    // The threshold that the trial does not have.
    const std::size_t other = own + (t == 0 ? count : std::size_t{sim::Theta});
    CHECK(rows[other * lanes] == 0.0);
    CHECK(rows[(own + (t == 0 ? std::size_t{sim::Theta} : count)) * lanes + 3] ==
          x[(own - Density::others + sim::Theta) * lanes + 3]);
  }
}

// With T the metric's inverse factor and A the information about all unknowns, T A T^t = 1.
TEST_CASE_FIXTURE(Pair, "Target: the metric is the inverse factor of all trials' information") {
  const Target two = target();
  for (const std::size_t held : {std::size_t{0}, std::size_t{Density::held}}) {
    std::vector<std::vector<double>> informations{information(1), information(2)}, metrics;
    const std::size_t all = 2 * own + count + 1;
    Matrix a(all, std::vector<double>(all, 0.0)), factor = a;
    for (std::size_t t = 0; t < 2; ++t) {
      two.parameters_last(t, informations[t], 1);
      const auto place = [&](std::size_t row) {
        if (row < own) return t * own + row;
        return 2 * own + common(t == 0 ? std::size_t{sim::Theta} : count)[row - own];
      };
      const auto is_held = [&](std::size_t row) { return row < own && row + held >= own; };
      for (std::size_t i = 0; i < size; ++i) {
        for (std::size_t j = 0; j < size; ++j) {
          const auto [low, high] = std::minmax(i, j);
          const bool apart = (is_held(i) || is_held(j)) && i != j;
          a[place(i)][place(j)] += apart ? 0.0 : is_held(i) ? 1.0 : informations[t][triangle(high) + low];
        }
      }
    }
    for (std::size_t p = 0; p < count; ++p)
      if (p != sim::Theta) a[2 * own + p][2 * own + p] -= 1.0;  // the prior counts once
    REQUIRE(two.metric(informations, held, metrics));
    for (std::size_t t = 0; t < 2; ++t)
      for (std::size_t i = 0; i < two.rows(t); ++i)
        for (std::size_t j = 0; j <= i; ++j)
          factor[i < own ? t * own + i : 2 * own + i - own][j < own ? t * own + j : 2 * own + j - own] =
              metrics[t][triangle(i) + j];
    double worst = 0.0;
    for (std::size_t i = 0; i < all; ++i) {
      std::vector<double> row(all, 0.0);  // of T A
      for (std::size_t k = 0; k <= i; ++k)
        for (std::size_t j = 0; j < all; ++j) row[j] += factor[i][k] * a[k][j];
      for (std::size_t j = 0; j <= i; ++j) {
        double product = 0.0;
        for (std::size_t k = 0; k <= j; ++k) product += row[k] * factor[j][k];
        worst = std::max(worst, std::abs(product - (i == j ? 1.0 : 0.0)));
      }
    }
    CHECK(worst < 1e-10);
    // The determinant of the information is that of the factors' diagonals.
    if (held > 0) continue;
    std::vector<std::vector<double>> factors(2);
    for (std::size_t t = 0; t < 2; ++t) {
      std::vector<double> one = informations[t];
      REQUIRE(factorize(size, one));
      for (const double value : one) factors[t].insert(factors[t].end(), lanes, value);
    }
    double expected = 0.0;
    for (std::size_t i = 0; i < all; ++i) expected -= std::log(factor[i][i]);
    for (const double found : two.half_log_determinant(factors)) CHECK(near(found, expected, 1e-10));
  }
}

TEST_CASE_FIXTURE(Pair, "Target: information that is not positive definite gives no metric") {
  std::vector<std::vector<double>> metrics;
  CHECK_FALSE(target().metric(std::vector(2, std::vector<double>(triangle(size), 0.0)), 0, metrics));
  CHECK(metrics.empty());
}

TEST_CASE_FIXTURE(Pair, "Target: the prior of a common unknown counts once") {
  Sampler sampler(target(), 3, 0);
  const std::vector<double> x = standard_normal(3, size * lanes);
  double alone[2], together = 0.0, prior = 0.0;
  for (std::size_t t = 0; t < 2; ++t) {
    alone[t] = Sampler(Target(density, observations[t]), 3, 0).potential(x)[2];
    together += sampler.potential(x, t)[2];
  }
  for (std::size_t p = 0; p < count; ++p) {
    const double value = x[(own - Density::others + p) * lanes + 2];
    if (p != sim::Theta) prior += 0.5 * value * value;
  }
  CHECK(near(together, alone[0] + alone[1] - prior, 1e-12));
}

TEST_CASE_FIXTURE(Pair, "Target: small steps keep the energy of all trials, with the metric of their information") {
  Sampler sampler(target(), 3, 1);
  std::vector<std::vector<double>> informations(2);
  for (std::size_t t = 0; t < 2; ++t) {
    for (int chain = 0; chain < lanes; ++chain)
      density.set({.parameters = some_parameters(), .sensor_noise_deg = 0.02}, sampler.coordinates(t), chain);
    std::vector<double> matrices(triangle(size) * lanes);
    sampler.information(sampler.coordinates(t), matrices, t);
    for (std::size_t i = 0; i < triangle(size); ++i) informations[t].push_back(matrices[i * lanes]);
    sampler.fix_noise(1.0, t);
    sampler.target().parameters_last(t, informations[t], 1);
  }
  REQUIRE(sampler.set_metric(informations));
  sampler.begin_adapting(1e-3);
  sampler.move(5);
  for (std::size_t l = 0; l < lanes; ++l) CHECK(sampler.acceptance()[l] > 0.99);
  for (std::size_t p = 0; p < count; ++p) {
    const std::size_t at = (own - Density::others + p) * lanes;
    for (std::size_t l = 0; l < lanes; ++l)
      CHECK((sampler.coordinates(0)[at + l] == sampler.coordinates(1)[at + l]) == (p != sim::Theta));
  }
}

TEST_CASE_FIXTURE(Pair, "sample_joint: trials have the same draws of common unknowns and their own of others") {
  Settings settings = quick();
  settings.max_leapfrog_steps = 8;
  const std::vector<Posterior> found = sample_joint(target(), settings);
  REQUIRE(found.size() == 2);
  REQUIRE(found[0].draws() > 0);
  REQUIRE(found[0].draws() == found[1].draws());
  for (std::size_t i = 0; i < found[0].states().size(); ++i) {
    const State &a = found[0].states()[i], &b = found[1].states()[i];
    for (std::size_t p = 0; p < count; ++p) CHECK((a.parameters[p] == b.parameters[p]) == (p != sim::Theta));
    CHECK(a.gain != b.gain);
  }
  const std::vector<Posterior> none = sample_joint(target(), settings, [](const Progress&) { return false; });
  REQUIRE(none.size() == 2);
  CHECK(none[1].draws() == 0);
}

// Common unknowns have one prior, though two trials have them.
TEST_CASE_FIXTURE(Pair, "Sampler: where two trials say nothing, transitions keep the prior") {
  Sampler sampler(target(), 3, 0);
  for (std::size_t t = 0; t < 2; ++t) sampler.fix_noise(1e6, t);
  std::vector<std::size_t> common;
  for (std::size_t p = 0; p < count; ++p)
    if (p != sim::Theta) common.push_back(p);
  const auto noises = static_cast<std::size_t>(density.noise_size());
  check_prior_is_kept(sampler, common, 1, noises, count, [] {});
}

TEST_CASE_FIXTURE(Pair, "Target: what does not fit together is refused") {
  const auto refused = [&](std::vector<TargetTrial> trials) {
    check_error([&] { Target target(std::move(trials)); }, Code::value_invalid);
  };
  const std::vector<std::size_t> usual = common(sim::Theta);
  refused({});
  refused({{&density, &observations[0], usual}, {&density, &observations[1], {}}});
  refused({{&density, &observations[0], {0, 1, 2}}, {&density, &observations[1], usual}});
  refused({{&density, &observations[0], common(sim::Kp)}, {&density, &observations[1], usual}});
  refused({{&density, &observations[0], common(count + 1)}, {&density, &observations[1], usual}});
  Priors narrow;
  narrow.parameters.push_back({.name = "Kp", .range = ParameterPrior::Range{600.0, 700.0}});
  const Density other(protocol, narrow);
  refused({{&density, &observations[0], usual}, {&other, &observations[1], usual}});
}
