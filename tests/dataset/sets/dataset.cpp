// Data sets: the same bits whatever the threads, every trial what its attempt says, children near their parents, groups
// whole, halves equal.
#include "dataset/sets/dataset.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/made_up_body.hpp"

using namespace decid;
using namespace decid::dataset;
using namespace decid::test;

namespace {

DatasetRequest request(int count, int base, std::uint64_t seed = 3) {
  return {tiny_protocol(), count, base, seed};
}

/// A trial of a data set by itself.
struct BaseTrial {
  sim::Parameters parameters;
  sim::Outcome outcome;
};
BaseTrial simulate_base_trial(const sim::Simulator& simulator, std::uint64_t seed, std::uint64_t attempt,
                              std::span<double> sway_rad) {
  const sim::TrialInput trial = base_trial(simulator.protocol().parameters(), seed, attempt);
  return {trial.parameters, simulator.run(trial.parameters, trial.noise, sway_rad)};
}

class Threads {
 public:
  explicit Threads(int count) : before_(omp_get_max_threads()) { omp_set_num_threads(count); }
  ~Threads() { omp_set_num_threads(before_); }
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

 private:
  int before_;
};

void check_equal(const Dataset& a, const Dataset& b) {
  CHECK(a.seed == b.seed);
  CHECK(a.samples == b.samples);
  CHECK(a.sway == b.sway);
  CHECK(a.parameters == b.parameters);
  CHECK(a.group == b.group);
  CHECK(a.split == b.split);
}

double exact_peak_to_peak(const std::vector<double>& sway) {
  const auto [least, most] = std::minmax_element(sway.begin(), sway.end());
  return *most - *least;
}

std::vector<float> as_float(const std::vector<double>& sway) {
  std::vector<float> result(sway.size());
  std::transform(sway.begin(), sway.end(), result.begin(), [](double value) { return static_cast<float>(value); });
  return result;
}

bool same(std::span<const float> a, const std::vector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

long long in_half(const std::vector<std::uint8_t>& split, int half) {
  return std::count(split.begin(), split.end(), half);
}

}  // namespace

TEST_CASE("the bits of a data set do not depend on the number of threads") {
  DatasetRequest wanted = request(400, 290);
  wanted.protocol.noise.sensor = {0.001, 0.1};
  std::vector<Dataset> sets;
  std::vector<DatasetReport> reports(3);
  for (int threads = 1; threads <= 3; ++threads) {
    const Threads scope(threads);
    sets.push_back(generate(wanted, &reports[static_cast<std::size_t>(threads - 1)]));
  }
  for (std::size_t i = 1; i < 3; ++i) {
    check_equal(sets[0], sets[i]);
    CHECK(reports[i].base_attempts == reports[0].base_attempts);
    CHECK(reports[i].child_attempts == reports[0].child_attempts);
    CHECK(reports[i].parents == reports[0].parents);
  }
  CHECK_FALSE(generate(request(5, 5, 4)).sway == generate(request(5, 5, 3)).sway);
}

TEST_CASE("base trials are the valid attempts, in order") {
  DatasetReport report;
  const Dataset data = generate(request(120, 0), &report);
  const sim::Simulator simulator(tiny_protocol());
  std::vector<double> sway(400);
  std::uint64_t attempt = 0;
  REQUIRE(data.trials() == 120);
  REQUIRE(data.samples == 400);
  for (int i = 0; i < data.trials(); ++i) {
    BaseTrial trial = simulate_base_trial(simulator, 3, attempt++, sway);
    while (!trial.outcome.valid) trial = simulate_base_trial(simulator, 3, attempt++, sway);
    CHECK(data.parameters[static_cast<std::size_t>(i)] == trial.parameters);
    CHECK(same(data.trial(i), as_float(sway)));
    CHECK(exact_peak_to_peak(sway) <= 2.0 * sim::sway_limit_rad);
    CHECK(data.group[static_cast<std::size_t>(i)] == i);
  }
  CHECK(report.base_attempts == static_cast<long long>(attempt));
  CHECK(report.base_attempts > 120);  // some did fall, or this test would not see them left out
  CHECK(report.child_attempts == 0);
}

TEST_CASE("a base trial's parameters are its attempt's numbers, within the ranges") {
  const sim::Simulator simulator(tiny_protocol());
  std::vector<double> sway(400), again(400);
  const BaseTrial trial = simulate_base_trial(simulator, 11, 7, sway);
  const Random random(11, sim::streams::base_parameters, 7);
  for (std::size_t i = 0; i < sim::single_pendulum().parameters.size(); ++i) {
    const sim::ParameterInfo& info = sim::single_pendulum().parameters[i];
    CHECK(trial.parameters[i] == random.uniform(i, info.low, info.high));
    CHECK(trial.parameters[i] > info.low);
    CHECK(trial.parameters[i] < info.high);
  }
  simulator.run(trial.parameters, Random(11, sim::streams::vestibular_noise, 7), again);
  CHECK(sway == again);
}

TEST_CASE("children: round robin over the parents, each near its parent and inside the ranges") {
  DatasetReport report;
  const int base = 100, count = 180;
  const Dataset data = generate(request(count, base), &report);
  const sim::Simulator simulator(tiny_protocol());
  std::vector<double> sway(400);
  std::vector<std::int32_t> parents;
  for (std::uint64_t attempt = 0, trial = 0; trial < base; ++attempt) {
    if (!simulate_base_trial(simulator, 3, attempt, sway).outcome.valid) continue;
    if (exact_peak_to_peak(sway) > parent_peak_to_peak_rad) parents.push_back(static_cast<std::int32_t>(trial));
    ++trial;
  }
  REQUIRE(parents.size() > 3);
  REQUIRE(parents.size() < 80);
  CHECK(report.parents == static_cast<int>(parents.size()));

  // The children again, from their description.
  int trial = base;
  long long attempts = 0;
  bool clamped = false;
  while (trial < count) {
    const auto c = static_cast<std::uint64_t>(attempts++);
    const std::int32_t parent = parents[c % parents.size()];
    const Random random(3, sim::streams::child_parameters, c);
    sim::Parameters parameters = data.parameters[static_cast<std::size_t>(parent)];
    for (std::size_t i = 0; i < sim::single_pendulum().parameters.size(); ++i) {
      const sim::ParameterInfo& info = sim::single_pendulum().parameters[i];
      const double wanted = parameters[i] + random.uniform(i, -0.1, 0.1) * (info.high - info.low);
      parameters[i] = std::min(std::max(wanted, info.low), info.high);
      clamped = clamped || parameters[i] != wanted;
    }
    if (!simulator.run(parameters, Random(3, sim::streams::child_noise, c), sway).valid) continue;
    REQUIRE(data.group[static_cast<std::size_t>(trial)] == parent);
    CHECK(data.parameters[static_cast<std::size_t>(trial)] == parameters);
    CHECK(same(data.trial(trial), as_float(sway)));
    for (std::size_t i = 0; i < sim::single_pendulum().parameters.size(); ++i) {
      const sim::ParameterInfo& info = sim::single_pendulum().parameters[i];
      const double value = parameters[i], mother = data.parameters[static_cast<std::size_t>(parent)][i];
      CHECK(value >= info.low);
      CHECK(value <= info.high);
      CHECK(std::abs(value - mother) <= 0.1 * (info.high - info.low) * (1.0 + 1e-9));
    }
    ++trial;
  }
  CHECK(report.child_attempts == attempts);
  CHECK(clamped);  // or this test would not see it left out
}

TEST_CASE("no group is divided and the halves are equal") {
  const Dataset data = generate(request(181, 101));
  for (std::size_t i = 0; i < data.group.size(); ++i) {
    CHECK(data.split[i] == data.split[static_cast<std::size_t>(data.group[i])]);
  }
  CHECK(std::abs(in_half(data.split, 0) - in_half(data.split, 1)) == 1);
}

TEST_CASE("sway is stored as the protocol records it, with noise by attempt, and nothing else changes") {
  const Dataset exact = generate(request(150, 100));
  DatasetRequest asked = request(150, 100);
  const sim::SensorNoise noise_deg{0.5, 0.5};  // large enough to change peak-to-peak values
  asked.protocol.noise.sensor = noise_deg;
  DatasetReport report;
  const Dataset noisy = generate(asked, &report);
  CHECK(noisy.parameters == exact.parameters);
  CHECK(noisy.group == exact.group);
  CHECK(noisy.split == exact.split);
  asked = request(150, 100);
  asked.protocol.conditions[sim::Condition::gain] = {.fraction = 1.0, .low = 0.0, .high = 0.3};
  const Dataset scaled = generate(asked);
  // The last trial of each kind is its last attempt. Children's noises are other ones than those of base trials.
  const auto last_base = static_cast<std::uint64_t>(report.base_attempts - 1);
  const auto last_child = static_cast<std::uint64_t>(report.child_attempts - 1) | std::uint64_t{1} << 63;
  for (const auto& [trial, item] : {std::pair(99, last_base), std::pair(149, last_child)}) {
    std::vector<double> zero(400, 0.0);
    sim::add_sensor_noise(noise_deg, 3, item, zero);
    const double factor = 1.0 + sim::drawn(asked.protocol.conditions, sim::Condition::gain, 3, item);
    CHECK(factor != 1.0);
    for (std::size_t k = 0; k < 400; ++k) {
      // Both are rounded to float, below a quarter of a radian.
      const double noise = static_cast<double>(noisy.trial(trial)[k]) - static_cast<double>(exact.trial(trial)[k]);
      CHECK(within(noise, zero[k], 0x1p-26));
      CHECK(within(scaled.trial(trial)[k], factor * double{exact.trial(trial)[k]}, 0x1p-25));
    }
  }
}

TEST_CASE("progress rises to the total, and can stop the work") {
  int calls = 0, last = 0;
  generate(request(400, 300), nullptr, [&](int done, int total) {
    ++calls;
    CHECK(done >= last);
    CHECK(total == 400);
    last = done;
    return true;
  });
  CHECK(calls > 1);
  CHECK(last == 400);
  check_error([] { generate(request(1000, 0), nullptr, [](int, int) { return false; }); }, Code::stopped, "1000");
}

TEST_CASE("requests that cannot be met are refused") {
  check_error([] { generate(request(0, 0)); }, Code::setting_out_of_range, "0 trials");
  check_error([] { generate(request(-5, 0)); }, Code::setting_out_of_range, "-5 trials");
  check_error([] { generate(request(10, 11)); }, Code::setting_out_of_range, "11 base");
  check_error([] { generate(request(10, -1)); }, Code::setting_out_of_range, "-1 base");
  DatasetRequest quiet = request(10, 5);
  quiet.protocol.sequence().amplitude_deg = 0.01;
  quiet.protocol.noise.vestibular.scale_deg = 0.0;
  check_error([&] { generate(quiet); }, Code::trials_missing, "5 base");
  DatasetRequest falling = request(10, 0);
  falling.protocol.sequence().amplitude_deg = 45.0;
  falling.protocol.noise.vestibular = {.scale_deg = 100.0, .high_hz = 2.0, .exponent = 0.0};
  falling.protocol.experiment.body = {86.283, 0.05, 0.3};  // it falls faster than the delays allow
  check_error([&] { generate(falling); }, Code::body_falls, "10000 simulated");
  DatasetRequest invalid = request(10, 0);
  invalid.protocol.experiment.sample_rate_hz = -1.0;
  check_error([&] { generate(invalid); }, Code::setting_out_of_range, "sample_rate_hz");
#ifndef DECID_SANITIZED  // sanitizers end the program instead of throwing bad_alloc
  DatasetRequest huge = request(std::numeric_limits<int>::max(), 0);
  huge.protocol.sequence().lead_out_s = 3000.0;
  check_error([&] { generate(huge); }, Code::out_of_memory);
#endif
}

TEST_CASE("splitting by group") {
  CHECK(split_by_group({}).empty());
  CHECK(split_by_group({0}) == std::vector<std::uint8_t>{0});
  CHECK(split_by_group({0, 1}) == std::vector<std::uint8_t>{0, 1});
  CHECK(split_by_group({0, 0, 0}) == std::vector<std::uint8_t>{0, 0, 0});
  // Groups of several first: {1, 3, 4} to half 0, {2, 5} to half 1, then the single trial 0 to the smaller.
  CHECK(split_by_group({0, 1, 2, 1, 1, 2}) == std::vector<std::uint8_t>{1, 0, 1, 0, 0, 1});
  check_error([] { split_by_group({0, 2}); }, Code::file_damaged, "2 is");
  check_error([] { split_by_group({0, -1}); }, Code::file_damaged, "-1 is");

  // The paper's numbers: 10,000 base trials and 2,766 children of a few hundred parents make halves of 6,383.
  for (const int parents : {1, 7, 300, 2766}) {
    std::vector<std::int32_t> group(12766);
    for (int i = 0; i < 10000; ++i) group[static_cast<std::size_t>(i)] = i;
    for (int c = 0; c < 2766; ++c) group[static_cast<std::size_t>(10000 + c)] = 3 * (c % parents);
    const auto split = split_by_group(group);
    CHECK(in_half(split, 0) == 6383);
    CHECK(in_half(split, 1) == 6383);
    for (std::size_t i = 0; i < group.size(); ++i) REQUIRE(split[i] == split[static_cast<std::size_t>(group[i])]);
  }
}

TEST_CASE("targets without spread, and no targets") {
  const std::vector<sim::Parameters> equal(3, sim::single_pendulum().parameters.middle());
  const TargetScaling scaling = target_scaling(sim::single_pendulum().parameters, equal);
  for (std::size_t i = 0; i < sim::single_pendulum().parameters.size(); ++i)
    CHECK(near(scaling.mean[i], equal[0][i], 0x1p-51));
  for (const double stddev : scaling.stddev) CHECK(stddev == 1.0);
  check_error([&] { target_scaling(sim::single_pendulum().parameters, {}); }, Code::trials_missing);
  check_error([&] { scaling.unscale(std::vector<float>(6)); }, Code::size_mismatch, "6 values");
}

TEST_CASE("fourteen parameters of a made-up body are drawn, counted and scaled by its table") {
  const sim::ParameterTable& table = made_up_body().parameters;
  constexpr int count = 400;
  std::vector<sim::Parameters> drawn;
  TrialDistributions distributions(table);
  for (std::uint64_t i = 0; i < count; ++i) {
    drawn.push_back(base_trial(table, 3, i).parameters);
    REQUIRE(drawn.back().size() == 14);
    distributions.add(drawn.back(), 0.01);
  }
  CHECK(drawn[7] == base_trial(table, 3, 7).parameters);
  const TargetScaling scaling = target_scaling(table, drawn);
  REQUIRE(scaling.mean.size() == 14);
  REQUIRE(distributions.parameters.size() == 14);
  for (std::size_t p = 0; p < 14; ++p) {
    const Distribution& found = distributions.parameters[p];
    CHECK(found.count() == count);
    CHECK(found.low() == table[p].low);
    CHECK(found.high() == table[p].high);
    CHECK(found.below() + found.above() == 0);
    CHECK(near(found.mean(), scaling.mean[p], 1e-12));
    CHECK(near(found.stddev(), scaling.stddev[p], 1e-12));
    // Uniform: deviation range / sqrt(12), and its own error, 1 / sqrt(5 count) of it, five times.
    CHECK(near(scaling.stddev[p], table[p].range() / std::sqrt(12.0), 5.0 / std::sqrt(5.0 * count)));
  }
  const std::vector<float> target = scaling.scale(drawn[5]);
  REQUIRE(target.size() == 14);
  const sim::Parameters back = scaling.unscale(target);
  for (std::size_t p = 0; p < 14; ++p) {
    CHECK(near(target[p], (drawn[5][p] - scaling.mean[p]) / scaling.stddev[p], 0x1p-24));
    CHECK(near(back[p], drawn[5][p], 0x1p-24));
  }
  check_error([&] { scaling.unscale(std::vector<float>(7)); }, Code::size_mismatch, "7 values");
}
