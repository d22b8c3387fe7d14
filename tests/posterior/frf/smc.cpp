#include "posterior/frf/smc.hpp"

#include <omp.h>

#include <cmath>
#include <limits>

#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::test;

namespace {

/// Two normal coordinates of which the likelihood knows a + b to 0.1 about 1: a ridge.
void ridge(std::span<const double> x, frf::Local& local) {
  const double off = x[0] + x[1] - 1.0;
  local.misfit = 0.5 * off * off / 0.01;
  std::fill(local.gradient.begin(), local.gradient.end(), off / 0.01);
  std::fill(local.information.begin(), local.information.end(), 100.0);
}

double mean_of(const frf::SmcResult& result, std::size_t size, std::size_t coordinate, int power) {
  double sum = 0.0, count = 0.0;
  for (const auto& chain : result.chains) {
    for (std::size_t at = coordinate; at < chain.size(); at += size, count += 1.0)
      sum += power == 1 ? chain[at] : chain[at] * chain[at];
  }
  return sum / count;
}

const frf::SmcSettings plain{};

}  // namespace

TEST_CASE("a ridge of a normal density has its moments") {
  // Given a + b = 1 +- 0.1: (a + b) is known to (2 x 0.01 / 2.01)^1/2, a - b stays as it was, so a is 1/2 on average
  // (times 200/201) and has the variance (2 + 0.00995) / 4.
  const frf::SmcResult result = frf::sample_smc(2, 0, ridge, plain);
  CHECK(result.rhat.size() == 2);
  const double effective = std::min(result.effective[0], result.effective[1]);
  CHECK(effective >= plain.effective_draws);
  const double mean = mean_of(result, 2, 0, 1), square = mean_of(result, 2, 0, 2);
  const double variance = (2.0 + 2.0 / 201.0) / 4.0;
  // 4.5 standard errors.
  CHECK(within(mean, 0.5 * 200.0 / 201.0, 4.5 * std::sqrt(variance / effective)));
  CHECK(within(square - mean * mean, variance, 4.5 * variance * std::sqrt(2.0 / effective)));
}

TEST_CASE("edges of the prior cut the density, impossible places too, whatever gradient and information say") {
  // Uniform from 0 to 1 and exp(-5 x), possible below 0.8 only; the information is ten times too small.
  const auto slope = [](std::span<const double> x, frf::Local& local) {
    local.misfit = x[0] < 0.8 ? 5.0 * x[0] : std::numeric_limits<double>::infinity();
    local.gradient[0] = -3.0;
    local.information[0] = 2.0;
  };
  const frf::SmcResult result = frf::sample_smc(1, 1, slope, plain);
  for (const auto& chain : result.chains)
    for (const double x : chain) {
      CHECK(x > 0.0);
      CHECK(x < 0.8);
    }
  const double expected = 0.2 - 0.8 * std::exp(-4.0) / (1.0 - std::exp(-4.0));
  CHECK(within(mean_of(result, 1, 0, 1), expected, 4.5 * 0.17 / std::sqrt(result.effective[0])));
}

TEST_CASE("a place with an impossible likelihood and no gradient is not accepted") {
  // A ratio that is not a number would accept it, and a particle could not leave it by its gradient.
  const auto half = [](std::span<const double> x, frf::Local& local) {
    local.misfit = x[0] > 0.0 ? 0.0 : 1e4;
    local.gradient[0] = x[0] > 0.0 ? 0.0 : std::numeric_limits<double>::quiet_NaN();
    local.information[0] = 1.0;
  };
  const frf::SmcResult result = frf::sample_smc(1, 0, half, plain);
  for (const auto& chain : result.chains)
    for (const double x : chain) REQUIRE(x > 0.0);
}

TEST_CASE("two places far apart get their shares") {
  // Normals of deviation 0.05 about +-1.5, of equal weight: the population finds both.
  const auto places = [](std::span<const double> x, frf::Local& local) {
    const double at = x[0] > 0.0 ? 1.5 : -1.5, off = x[0] - at;
    local.misfit = 0.5 * off * off / 0.0025;
    local.gradient[0] = off / 0.0025;
    local.information[0] = 400.0;
  };
  frf::SmcSettings settings;
  settings.population = 1024;
  settings.chains = 64;
  settings.max_draws = settings.min_draws;
  const frf::SmcResult result = frf::sample_smc(1, 0, places, settings);
  int right = 0;
  for (const auto& chain : result.chains) right += chain.back() > 0.0 ? 1 : 0;
  CHECK(right > 18);  // of 64: +- 3.5 deviations of a coin
  CHECK(right < 46);
  CHECK(result.rhat[0] > 1.5);  // and that chains stay where they are is seen
}

TEST_CASE("the same settings draw the same, on any number of threads") {
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const frf::SmcResult one = frf::sample_smc(2, 0, ridge, plain);
  omp_set_num_threads(3);
  const frf::SmcResult three = frf::sample_smc(2, 0, ridge, plain);
  omp_set_num_threads(threads);
  CHECK(one.chains == three.chains);
  frf::SmcSettings other;
  other.seed = 2;
  CHECK(frf::sample_smc(2, 0, ridge, other).chains != one.chains);
}

TEST_CASE("settings that are too small are errors") {
  const auto with = [](auto change) {
    return [change] {
      frf::SmcSettings settings;
      change(settings);
      frf::sample_smc(2, 0, ridge, settings);
    };
  };
  check_error(with([](auto& s) { s.population = 4; }), Code::setting_out_of_range, "16 or more");
  check_error(with([](auto& s) { s.stage_transitions = 0; }), Code::setting_out_of_range, "stage_transitions");
  check_error(with([](auto& s) { s.settling_transitions = -1; }), Code::setting_out_of_range, "settling_transitions");
  check_error(with([](auto& s) { s.chains = 0; }), Code::setting_out_of_range);
  check_error(with([](auto& s) { s.thinning = 0; }), Code::setting_out_of_range);
  check_error(with([](auto& s) { s.min_draws = 3; }), Code::setting_out_of_range, "min_draws");
  check_error(with([](auto& s) { s.max_draws = 10; }), Code::setting_out_of_range, "max_draws");
  check_error([] { frf::sample_smc(29, 0, ridge, plain); }, Code::setting_out_of_range, "29 coordinates");
  const auto never = [](std::span<const double>, frf::Local& local) {
    local.misfit = std::numeric_limits<double>::infinity();
  };
  check_error([&] { frf::sample_smc(1, 0, never, plain); }, Code::setting_out_of_range, "likelihood is 0");
}
