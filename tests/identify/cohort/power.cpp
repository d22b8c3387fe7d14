// Power of a study: against figures of mpmath with 20 digits, Cohen's table, and simulated studies.
#include "identify/cohort/power.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/math/random.hpp"
#include "identify/groups.hpp"
#include "tests/helpers.hpp"
#include "tests/near.hpp"

using decid::Code;
using decid::cohort::participants_for;
using decid::cohort::power_of;
using decid::cohort::PowerDesign;
using decid::cohort::trials_for;
using namespace decid::test;

namespace {

PowerDesign standard(std::size_t participants) {
  PowerDesign design;
  design.participants = participants;
  design.participant_sd = 1.0;
  return design;
}

/// The fraction of simulated studies whose 95% interval leaves out 0.
double simulated(const PowerDesign& design, double difference, int studies) {
  const decid::Random random(21, decid::Stream::user, 0);
  std::uint64_t used = 0;
  const auto normal = [&] { return random.normal(used++); };
  int found = 0;
  for (int study = 0; study < studies; ++study) {
    std::vector<decid::GroupedRecording> recordings;
    for (std::size_t i = 0; i < design.participants; ++i) {
      const double shared = design.participant_sd * normal();
      for (const char* group : {"a", "b"}) {
        const double own = design.paired ? shared + design.visit_sd * normal() : design.participant_sd * normal();
        for (std::size_t trial = 0; trial < design.trials; ++trial) {
          double value = own + (*group == 'b' ? difference : 0.0) + design.trial_sd * normal();
          value += design.measurement_sd * normal();
          recordings.push_back({group, (design.paired ? "" : group) + std::to_string(i), {value}});
        }
      }
    }
    const auto interval = decid::compare_groups(recordings, 1).pairs.at(0).parameters.at(0).interval95;
    found += interval[0] > 0.0 || interval[1] < 0.0 ? 1 : 0;
  }
  return found / static_cast<double>(studies);
}

}  // namespace

TEST_CASE("power: two groups and pairs") {
  CHECK(near(power_of(standard(64), 0.5), 0.801459557922, 1e-7));  // Cohen 1988, table 2.4.1: 64 for 0.80
  CHECK(near(power_of(standard(12), 1.0), 0.648642550727, 1e-7));
  CHECK(near(power_of(standard(2), -3.0), 0.387400128526, 1e-6));
  PowerDesign pairs = standard(6);
  pairs.paired = true;
  pairs.visit_sd = 1.0;
  CHECK(near(power_of(pairs, 0.8), 0.204917559714, 1e-7));
  CHECK(near(power_of(standard(12), 0.0), 0.05, 1e-7));
  CHECK(participants_for(standard(2), 0.5, 0.8) == 64);
  CHECK(participants_for(standard(2), 1e-4, 0.8) == 0);
  PowerDesign noisy = standard(12);
  noisy.measurement_sd = 1.0;
  noisy.trials = 4;
  PowerDesign wider = standard(12);
  wider.participant_sd = std::sqrt(1.25);
  CHECK(near(power_of(noisy, 1.0), power_of(wider, 1.0), 1e-12));
}

TEST_CASE("power: the number of trials that is enough, and people who differ too much for any number") {
  PowerDesign design = standard(20);
  design.participant_sd = 0.5;
  design.measurement_sd = 1.0;
  const std::size_t enough = trials_for(design, 0.6, 0.8);
  REQUIRE(enough > 1);
  design.trials = enough;
  CHECK(power_of(design, 0.6) >= 0.8);
  design.trials = enough - 1;
  CHECK(power_of(design, 0.6) < 0.8);
  CHECK(trials_for(design, 5.0, 0.8) == 1);
  design.participant_sd = 1.0;
  CHECK(trials_for(design, 0.6, 0.8) == 0);  // 0.8 takes 45 participants without any other error
  design.participant_sd = 0.5;
  design.measurement_sd = 20.0;
  CHECK(trials_for(design, 0.6, 0.8) == 0);  // more than 1,000
}

// Four standard deviations of 2,000 studies are 0.045 at most; predicted powers are right within 0.03.
TEST_CASE("power: predicted within three points of simulated studies") {
  PowerDesign groups = standard(12);
  groups.trial_sd = 0.4;
  groups.measurement_sd = 0.5;
  groups.trials = 3;
  PowerDesign pairs = groups;
  pairs.paired = true;
  pairs.visit_sd = 0.6;
  for (const double difference : {0.6, 1.2}) {
    CHECK(within(power_of(groups, difference), simulated(groups, difference, 2000), 0.03));
    CHECK(within(power_of(pairs, difference), simulated(pairs, difference, 2000), 0.03));
  }
}

TEST_CASE("power: designs that cannot be are refused") {
  check_error([&] { (void)power_of(standard(1), 1.0); }, Code::setting_out_of_range);
  check_error([&] { (void)power_of(PowerDesign{}, 1.0); }, Code::value_invalid);
  check_error([&] { (void)power_of(standard(5), std::nan("")); }, Code::value_invalid);
  PowerDesign design = standard(5);
  design.trial_sd = -1.0;
  check_error([&] { (void)power_of(design, 1.0); }, Code::setting_out_of_range);
  design.trial_sd = std::nan("");
  check_error([&] { (void)power_of(design, 1.0); }, Code::setting_out_of_range);
  design = standard(5);
  design.trials = 0;
  check_error([&] { (void)power_of(design, 1.0); }, Code::setting_out_of_range);
  check_error([&] { (void)participants_for(standard(5), 1.0, 1.0); }, Code::setting_out_of_range);
  check_error([&] { (void)trials_for(standard(5), 1.0, 0.0); }, Code::setting_out_of_range);
}
