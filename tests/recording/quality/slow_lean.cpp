// A person who leans slowly: found from 1 degree on, and not in sound trials, behind a drift or in other protocols.
#include "recording/quality/detail/slow_lean.hpp"

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

/// Returns trial i of the whole prior in rad, without measurement noise.
std::vector<double> trial(std::uint64_t i) {
  const sim::ParameterTable& table = simulator().protocol().parameters();
  std::vector<double> values(static_cast<std::size_t>(simulator().samples()));
  for (std::uint64_t attempt = 0;; ++attempt) {
    const Random random(13, sim::streams::base_parameters, 1000 * i + attempt);
    sim::Parameters parameters(table.size());
    for (std::size_t p = 0; p < table.size(); ++p) parameters[p] = random.uniform(p, table[p].low, table[p].high);
    if (simulator().run(parameters, Random(13, sim::streams::vestibular_noise, 1000 * i + attempt), values).valid)
      return values;
  }
}

/// Adds a lean of this amplitude, in degrees, and this period to trial i.
std::vector<double> leaning(std::uint64_t i, double amplitude_deg, double period_s) {
  std::vector<double> values = trial(i);
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] += amplitude_deg * sim::rad_per_deg *
                 std::sin(6.2831853 * 0.01 * static_cast<double>(k) / period_s + static_cast<double>(i));
  return values;
}

bool is_found(const std::vector<double>& sway_rad, const sim::Protocol& protocol = simulator().protocol()) {
  Warnings warnings;
  look_for_slow_lean(sway_rad, protocol, warnings);
  REQUIRE(warnings.size() <= 1);
  if (!warnings.empty()) {
    CHECK(warnings[0].code == "slow_lean");
    CHECK(warnings[0].severity == Severity::caution);
  }
  return !warnings.empty();
}

}  // namespace

TEST_CASE("a slow lean of a degree gets a caution, also from bring_to_protocol") {
  int found = 0;
  for (std::uint64_t i = 0; i < 20; ++i) {
    CHECK(is_found(leaning(i, 1.0, 40.0)));
    found += is_found(leaning(i, 1.0, 80.0)) ? 1 : 0;
  }
  CHECK(found >= 10);
  Recording recording = make_recording(leaning(0, 1.0, 40.0), 100.0);
  bring_to_protocol(recording, plan());
  CHECK(std::ranges::count(recording.warnings, "slow_lean", &Warning::code) == 1);
}

TEST_CASE("sound trials, also behind a drift of 2 degrees, have no slow lean; other protocols are not checked") {
  for (std::uint64_t i = 0; i < 60; ++i) {
    std::vector<double> values = trial(i);
    CHECK_FALSE(is_found(values));
    for (std::size_t k = 0; k < values.size(); ++k)
      values[k] += 2.0 * sim::rad_per_deg * static_cast<double>(k) / static_cast<double>(values.size());
    CHECK_FALSE(is_found(values));
  }
  sim::Protocol other = simulator().protocol();
  const std::vector<double> values = leaning(0, 1.0, 40.0);
  other.sequence().amplitude_deg = 4.0;
  CHECK_FALSE(is_found(values, other));
  other = simulator().protocol();
  other.noise.vestibular.scale_deg = 0.4;
  CHECK_FALSE(is_found(values, other));
}
