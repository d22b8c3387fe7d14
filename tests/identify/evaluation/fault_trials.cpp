// Trials with a fault: each differs from the same trial without it by what its name says.
#include "identify/evaluation/fault_trials.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "identify/evaluation/faults.hpp"

namespace decid {
namespace {

constexpr std::uint64_t seed = 5;

sim::Protocol standing_protocol() {
  sim::Protocol protocol = sim::default_protocol();
  protocol.standing_s = 10.0;
  return protocol;
}

FaultTrials::Trials trials_with(const sim::Protocol& protocol, const Fault& fault, int count) {
  const sim::Protocol recorded = with_fault(protocol, fault);
  return FaultTrials(protocol, recorded, fault, seed).take(0, count);
}

std::vector<float> sway_with(const Fault& fault) {
  return trials_with(standing_protocol(), fault, 1).sways.front().sway_rad();
}

/// The sway with the fault less that without, degrees.
std::vector<double> difference_of(const Fault& fault) {
  const std::vector<float> with = sway_with(fault), without = sway_with({"none"});
  REQUIRE(with.size() == without.size());
  std::vector<double> difference;
  for (std::size_t i = 0; i < with.size(); ++i)
    difference.push_back((static_cast<double>(with[i]) - static_cast<double>(without[i])) / sim::rad_per_deg);
  return difference;
}

double mean_square(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return sum / static_cast<double>(values.size());
}

}  // namespace

TEST_CASE("trials with a fault have the parameters of those without") {
  const sim::Protocol protocol = standing_protocol();
  const FaultTrials::Trials plain = trials_with(protocol, {"none"}, 2);
  REQUIRE(plain.truth.size() == 2);
  for (const Fault& fault : faults_of_people()) {
    CAPTURE(fault.name);
    CHECK(impossible(protocol, fault).empty());
    if (fault.name == "tilt" || fault.name == "double_pendulum" || fault.name == "none") continue;
    const FaultTrials::Trials made = trials_with(protocol, fault, 1);
    CHECK(made.truth == std::vector<sim::Parameters>{plain.truth[0]});
    CHECK(made.sways[0].sway_rad().size() == plain.sways[0].sway_rad().size());
    CHECK(made.sways[0].sway_rad() != plain.sways[0].sway_rad());
  }
  CHECK(trials_with(protocol, {"double_pendulum"}, 1).truth.empty());
}

TEST_CASE("trials of a controller with a convention have its value, and all others their draws") {
  sim::Protocol protocol = standing_protocol();
  protocol.experiment.body_model = &sim::dec2015();
  const sim::ParameterTable ranges = protocol.ranges();
  REQUIRE(std::ranges::any_of(ranges, [](const sim::ParameterInfo& info) { return info.convention.has_value(); }));
  const FaultTrials::Trials made = trials_with(protocol, {"none"}, 2);
  REQUIRE(made.truth.size() == 2);
  for (std::size_t p = 0; p < ranges.size(); ++p) {
    if (ranges[p].convention) CHECK(made.truth[0][p] == *ranges[p].convention);
    CHECK((made.truth[0][p] == made.truth[1][p]) == ranges[p].convention.has_value());
  }
}

TEST_CASE("a gap is one straight line of its length") {
  const std::vector<float> with = sway_with({"gap_s", 2.0});
  const std::vector<double> difference = difference_of({"gap_s", 2.0});
  const auto differs = [](double value) { return value != 0.0; };
  const auto first = std::ranges::find_if(difference, differs) - difference.begin();
  const auto last = std::find_if(difference.rbegin(), difference.rend(), differs).base() - difference.begin();
  CHECK(last - first <= 200);
  CHECK(last - first > 190);
  for (auto i = first; i + 2 < last; ++i) {
    const auto at = [&](std::ptrdiff_t k) { return static_cast<double>(with[static_cast<std::size_t>(k)]); };
    CHECK(std::abs(at(i) - 2.0 * at(i + 1) + at(i + 2)) < 1e-8);  // the rounding of floats of some 0.02 rad
  }
}

TEST_CASE("coloured noise has its deviation, and forgets within half a second") {
  const std::vector<double> noise = difference_of({"coloured_noise_deg", 0.05});
  double together = 0.0;
  for (std::size_t i = 1; i < noise.size(); ++i) together += noise[i] * noise[i - 1];
  const double square = mean_square(noise);
  // Some 120 values are independent: 30% is 3.3 of the square's relative standard error of sqrt(2 / 120) and more.
  CHECK(std::abs(std::sqrt(square) / 0.05 - 1.0) < 0.3);
  CHECK(std::abs(together / static_cast<double>(noise.size()) / square - 0.98) < 0.01);
}

TEST_CASE("a body at rest begins at 0, one that stood before does not") {
  CHECK(sway_with({"at_rest"}).front() == 0.0F);
  CHECK(std::abs(sway_with({"none"}).front()) > 1e-5F);
}

TEST_CASE("half the rate is resampled, and the reader says so") {
  const sim::Protocol protocol = standing_protocol();
  const FaultTrials::Trials made = trials_with(protocol, {"rate_hz", 50.0}, 1);
  REQUIRE(made.warnings.size() == 1);
  CHECK(std::ranges::any_of(made.warnings[0], [](const Warning& warning) { return warning.code == "resampled"; }));
  CHECK(mean_square(difference_of({"rate_hz", 50.0})) < 1e-5);
}

TEST_CASE("artefacts that a protocol cannot have are named") {
  sim::Protocol slow = standing_protocol();
  slow.experiment.sample_rate_hz = 50.0;
  CHECK_FALSE(impossible(slow, {"rate_hz", 50.0}).empty());
  CHECK_FALSE(impossible(slow, {"average_s", 0.01}).empty());
  CHECK_FALSE(impossible(slow, {"low_pass_hz", 25.0}).empty());
  CHECK_FALSE(impossible(slow, {"lost_s", 0.005}).empty());
  CHECK(impossible(slow, {"offset_deg", 1.0}).empty());
}

// One of 13,000 such trials got the warning: at this rate two of these 900 or more do with a probability of 0.2%.
TEST_CASE("sound recordings with a fault are hardly ever said to have a wrong clock" * doctest::test_suite("slow")) {
  const sim::Protocol protocol = standing_protocol();
  int warned = 0, trials = 0;
  for (const Fault& fault : all_faults()) {
    const sim::Protocol recorded = with_fault(protocol, fault);
    const FaultTrials::Trials made = FaultTrials(protocol, recorded, fault, 2036).take(0, 20);
    trials += static_cast<int>(made.warnings.size());
    for (const Warnings& warnings : made.warnings)
      warned += std::ranges::count(warnings, "clock_differs", &Warning::code) > 0 ? 1 : 0;
  }
  CHECK(trials > 700);
  CHECK(warned <= 1);
}

// Slow: 46 rows of simulated trials, each explained by 33 others.
TEST_CASE("a study of faults counts the trials with a warning" * doctest::test_suite("slow")) {
  const FaultStudy study = study_faults(built_in_model(), 0.02, 2, 2035, [](const std::string&) {});
  CHECK(study.rows.size() + study.notes.size() == all_faults().size());
  for (const FaultFigures& row : study.rows) {
    CAPTURE(row.fault.text);
    CHECK((row.warned == 0.0 || row.warned == 0.5 || row.warned == 1.0));
    if (row.fault.name == "none") CHECK(row.warned <= 0.5);
    if (row.fault.name == "upside_down") CHECK(row.warned == 1.0);
  }
}

}  // namespace decid
