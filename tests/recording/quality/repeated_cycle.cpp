// A cycle that was copied, such as the mean of cycles: found, and not in trials of bodies without any noise.
#include "recording/quality/detail/repeated_cycle.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/math/random.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/recording/default_protocol.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

/// Returns trial i of the prior in rad, without measurement noise; without vestibular noise if `is_noise_free`.
std::vector<double> trial(std::uint64_t i, bool is_noise_free) {
  const sim::ParameterTable& table = simulator().protocol().parameters();
  std::vector<double> values(static_cast<std::size_t>(simulator().samples()));
  for (std::uint64_t attempt = 0;; ++attempt) {
    const Random random(12, sim::streams::base_parameters, 1000 * i + attempt);
    sim::Parameters parameters(table.size());
    for (std::size_t p = 0; p < table.size(); ++p) parameters[p] = random.uniform(p, table[p].low, table[p].high);
    if (is_noise_free) parameters[sim::Nv] = 0.0;
    if (simulator().run(parameters, Random(12, sim::streams::vestibular_noise, 1000 * i + attempt), values).valid)
      return values;
  }
}

Warnings found(const std::vector<double>& sway_rad) {
  Warnings warnings;
  look_for_repeated_cycle(sway_rad, simulator().protocol().experiment, warnings);
  return warnings;
}

}  // namespace

TEST_CASE("a mean of cycles that is written twice gets a caution, also if its ends differ") {
  for (std::uint64_t i = 0; i < 10; ++i) {
    std::vector<double> mean = trial(i, false);
    const std::size_t half = mean.size() / 2;
    for (std::size_t k = 0; k < half; ++k) mean[k] = mean[half + k] = 0.5 * (mean[k] + mean[half + k]);
    const Warnings warnings = found(mean);
    REQUIRE(warnings.size() == 1);
    CHECK(warnings[0].code == "repeated_cycle");
    CHECK(warnings[0].severity == Severity::caution);
    for (std::size_t k = half - 50; k < half + 50; ++k) mean[k] += 1e-3;
    CHECK(found(mean).size() == 1);
    Recording recording = make_recording(mean, 100.0);
    bring_to_protocol(recording, plan());
    CHECK(std::ranges::count(recording.warnings, "repeated_cycle", &Warning::code) == 1);
  }
}

TEST_CASE("trials, also without any noise, a still sway and a protocol of one cycle repeat no cycle") {
  for (std::uint64_t i = 0; i < 40; ++i) CHECK(found(trial(i, i % 2 == 0)).empty());
  CHECK(found(std::vector<double>(12100, 0.01)).empty());
  sim::Protocol one_cycle = sim::default_protocol();
  one_cycle.sequence().cycles = 1;
  Warnings warnings;
  look_for_repeated_cycle(std::vector<double>(6050, 0.01), one_cycle.experiment, warnings);
  CHECK(warnings.empty());
}
