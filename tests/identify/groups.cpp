// Groups compared: against published figures, figures computed with 40 digits, and the false alarms of null studies.
#include "identify/groups.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "base/error.hpp"
#include "base/math/random.hpp"
#include "tests/near.hpp"

using decid::compare_groups;
using decid::group_sample;
using decid::GroupComparison;
using decid::GroupedRecording;
using decid::GroupEffect;
using decid::GroupSample;
using decid::independent_effect;
using decid::paired_effect;
using namespace decid::test;

namespace {

bool leaves_out_zero(const std::array<double, 2>& interval) {
  return interval[0] > 0.0 || interval[1] < 0.0;
}

constexpr std::size_t parameters = 7;

/// Two groups from one population: `people` in each, `trials` recordings per person whose intraclass correlation is
/// 0.8, seven independent parameters. person_named: the recordings say whose they are.
std::vector<GroupedRecording> null_study(std::uint64_t number, bool participant_named, int participants = 10,
                                         int trials = 4) {
  const decid::Random random(17, decid::Stream{9}, number);
  std::uint64_t drawn = 0;
  std::vector<GroupedRecording> study;
  for (const char* group : {"a", "b"})
    for (int participant = 0; participant < participants; ++participant) {
      std::array<double, parameters> own{};
      for (double& value : own) value = std::sqrt(0.8) * random.normal(drawn++);
      for (int trial = 0; trial < trials; ++trial) {
        GroupedRecording recording{group, group + std::to_string(participant), {own.begin(), own.end()}};
        if (!participant_named) recording.participant += '/' + std::to_string(trial);
        for (double& value : recording.values) value += std::sqrt(0.2) * random.normal(drawn++);
        study.push_back(recording);
      }
    }
  return study;
}

/// How many of `studies` null studies' intervals leave out 0, as fractions.
struct FalseAlarms {
  double interval95 = 0.0;               ///< of all parameters' intervals
  double any = 0.0, any_adjusted = 0.0;  ///< of the studies: at least one parameter
};
FalseAlarms false_alarms(int studies, bool participant_named) {
  FalseAlarms alarms;
  for (int study = 0; study < studies; ++study) {
    int alone = 0, adjusted = 0;
    const GroupComparison found =
        compare_groups(null_study(static_cast<std::uint64_t>(study), participant_named), parameters);
    for (const GroupEffect& effect : found.pairs.at(0).parameters) {
      alone += leaves_out_zero(effect.interval95) ? 1 : 0;
      adjusted += leaves_out_zero(effect.adjusted_interval95) ? 1 : 0;
    }
    alarms.interval95 += alone / (7.0 * studies);
    alarms.any += (alone > 0 ? 1.0 : 0.0) / studies;
    alarms.any_adjusted += (adjusted > 0 ? 1.0 : 0.0) / studies;
  }
  return alarms;
}

}  // namespace

TEST_CASE("groups: Hedges' g of Borenstein et al. 2009, page 27") {
  const GroupEffect found = independent_effect({50, 103.0, 5.5}, {50, 100.0, 4.5}, 1);
  CHECK(found.difference == 3.0);
  CHECK(within(found.hedges_g, 0.5924, 0.00005));
}

TEST_CASE("groups: two small groups of different people") {
  const GroupSample first = group_sample(std::vector<double>{812, 905, 777, 860, 930});
  const GroupSample second = group_sample(std::vector<double>{700, 655, 742, 801});
  CHECK(first.count == 5);
  CHECK(near(first.mean, 856.8, 1e-14));
  CHECK(near(first.sd, 63.37744078140107, 1e-14));
  CHECK(near(second.sd, 62.153036933041335, 1e-14));
  const GroupEffect found = independent_effect(first, second, 7);
  CHECK(near(found.hedges_g, 1.870954512360277, 1e-13));
  CHECK(near(found.interval95[0], 31.697937537407547, 1e-12));
  CHECK(near(found.interval95[1], 232.90206246259245, 1e-13));
  CHECK(near(found.adjusted_interval95[0], -28.896174397845642, 1e-12));
  CHECK(near(found.adjusted_interval95[1], 293.49617439784564, 1e-13));
  const GroupEffect turned = independent_effect(second, first, 7);
  CHECK(turned.hedges_g == -found.hedges_g);
  CHECK(turned.interval95[0] == -found.interval95[1]);
  CHECK(independent_effect(first, second, 1).adjusted_interval95 == found.interval95);
}

TEST_CASE("groups: the same people in two groups are compared in pairs") {
  const std::vector<double> first{812, 905, 777, 860}, second{700, 655, 742, 801};
  const GroupEffect found = paired_effect(first, second, 7);
  CHECK(found.difference == 114.0);
  CHECK(near(found.interval95[0], -39.083055321466723, 1e-12));
  CHECK(near(found.adjusted_interval95[1], 430.49781062497381, 1e-13));
  CHECK(near(found.hedges_g, 1.4028229438073999, 1e-13));
  CHECK_THROWS_AS(paired_effect(first, std::vector<double>{1.0}, 7), decid::Error);
}

TEST_CASE("groups: undefined figures are NaN") {
  const GroupSample none = group_sample({}), one = group_sample(std::vector<double>{4.0});
  CHECK(std::isnan(none.mean));
  CHECK(one.mean == 4.0);
  CHECK(std::isnan(one.sd));
  const GroupSample two = group_sample(std::vector<double>{1.0, 3.0}), still = group_sample(std::vector<double>{2, 2});
  CHECK(independent_effect(one, two, 7).difference == 2.0);
  CHECK(std::isnan(independent_effect(one, two, 7).hedges_g));
  CHECK(std::isnan(independent_effect(two, none, 7).interval95[0]));
  CHECK(std::isnan(independent_effect(still, still, 7).hedges_g));
  // Means of equal values that are rounded, and equal differences of people.
  const GroupSample seven = group_sample(std::vector(7, 0.1)), six = group_sample(std::vector(6, 0.3));
  CHECK(seven.sd == 0.0);
  CHECK(std::isnan(independent_effect(seven, six, 7).interval95[0]));
  CHECK(std::isnan(independent_effect(seven, six, 7).hedges_g));
  const std::vector<double> before{0.1, 0.2, 0.3, 0.4}, after{0.2, 0.3, 0.4, 0.5};
  CHECK(std::isnan(paired_effect(before, after, 7).interval95[0]));
  CHECK(independent_effect(two, still, 7).hedges_g == 0.0);
  CHECK(independent_effect(two, still, 7).interval95[1] > 0.0);
  const std::vector<double> rising{1, 2, 3}, later{2, 3, 4};
  CHECK(std::isnan(paired_effect(rising, later, 7).interval95[0]));  // everyone's difference is the same
  CHECK(paired_effect(rising, later, 7).hedges_g < 0.0);
  const GroupEffect two_pairs = paired_effect(std::vector<double>{1, 3}, std::vector<double>{2, 7}, 7);
  CHECK(std::isnan(two_pairs.hedges_g));
  CHECK(two_pairs.difference == -2.5);
  CHECK(two_pairs.interval95[0] < two_pairs.interval95[1]);
  CHECK(std::isnan(paired_effect(std::vector<double>{1.0}, std::vector<double>{2.0}, 7).interval95[0]));
}

TEST_CASE("groups: recordings of a person are averaged before people are compared") {
  // One person with four recordings weighs as much as one with a single recording; c3's recording is left out.
  const std::vector<GroupedRecording> recordings{{"p", "p1", {1, 10}}, {"c", "c1", {4, 0}},  {"p", "p1", {3, 10}},
                                                 {"p", "p1", {5, 10}}, {"p", "p1", {7, 10}}, {"p", "p2", {10, 30}},
                                                 {"c", "c2", {6, 2}},  {"c", "c3", {}},      {"empty", "e", {}}};
  const GroupComparison found = compare_groups(recordings, 2);
  REQUIRE(found.groups.size() == 3);
  CHECK(found.groups[0].name == "c");
  CHECK(found.groups[0].participants == 2);
  CHECK(found.groups[1].participants == 0);
  CHECK(found.groups[2].participants == 2);
  CHECK(found.groups[2].recordings == 5);
  CHECK(found.groups[2].parameters[0].mean == 7.0);
  CHECK(near(found.groups[2].parameters[0].sd, std::sqrt(18.0), 1e-15));
  REQUIRE(found.pairs.size() == 1);  // without the group of nobody
  CHECK(found.intervals == 2);
  CHECK(found.too_small == std::vector<std::size_t>{1});
  CHECK(found.pairs[0].first == 0);
  CHECK(found.pairs[0].second == 2);
  CHECK_FALSE(found.pairs[0].paired);
  CHECK(found.pairs[0].parameters[0].difference == -2.0);
  CHECK_THROWS_AS(compare_groups(recordings, 3), decid::Error);
}

TEST_CASE("groups: a group of one person does not widen the intervals of the others; alone it is compared") {
  std::vector<GroupedRecording> recordings{{"patients", "p1", {1}},
                                           {"patients", "p2", {4}},
                                           {"controls", "c1", {2}},
                                           {"controls", "c2", {5}},
                                           {"controls", "c3", {6}}};
  const GroupComparison without = compare_groups(recordings, 1);
  recordings.push_back({"patient", "p3", {3}});
  const GroupComparison found = compare_groups(recordings, 1);
  CHECK(found.groups.size() == 3);
  REQUIRE(found.pairs.size() == 1);
  CHECK(found.intervals == 1);
  CHECK(found.too_small == std::vector<std::size_t>{1});
  CHECK(found.pairs[0].parameters[0].adjusted_interval95 == without.pairs[0].parameters[0].adjusted_interval95);
  CHECK(without.too_small.empty());
  const GroupComparison one = compare_groups(std::span(recordings).subspan(2), 1);  // controls and one patient
  REQUIRE(one.pairs.size() == 1);
  CHECK(one.too_small.empty());
  CHECK(std::isnan(one.pairs[0].parameters[0].interval95[0]));
}

TEST_CASE("groups: numbers in names count") {
  std::vector<GroupedRecording> recordings;
  for (const char* session : {"10", "2", "1"})
    for (const char* person : {"a", "b"})
      recordings.push_back({session, person, {std::stod(session) + (*person == 'a' ? 0.0 : 0.5)}});
  const GroupComparison found = compare_groups(recordings, 1);
  REQUIRE(found.groups.size() == 3);
  CHECK(found.groups[1].name == "2");
  CHECK(found.groups[2].name == "10");
  CHECK(found.pairs[2].parameters[0].difference == -8.0);  // 2 minus 10
}

TEST_CASE("groups: someone in both groups makes the comparison paired, without people in one of them only") {
  const std::vector<GroupedRecording> recordings{{"after", "s1", {12}},  {"after", "s2", {15}},  {"after", "s3", {11}},
                                                 {"before", "s1", {9}},  {"before", "s1", {11}}, {"before", "s2", {11}},
                                                 {"before", "s3", {10}}, {"before", "s4", {900}}};
  const GroupComparison found = compare_groups(recordings, 1);
  REQUIRE(found.pairs.size() == 1);
  CHECK(found.pairs[0].paired);
  CHECK(found.pairs[0].participants == std::array<std::size_t, 2>{3, 3});
  CHECK(found.pairs[0].unpaired_participants == 1);
  const GroupEffect expected = paired_effect(std::vector<double>{12, 15, 11}, std::vector<double>{10, 11, 10}, 1);
  CHECK(found.pairs[0].parameters[0].interval95 == expected.interval95);
  CHECK(found.groups[1].participants == 4);
}

// Bounds are 4 standard deviations of the measured fractions from what correct intervals give, so a correct program
// fails one of the three two-sided or one-sided checks with a probability below 2e-4, for another seed.
TEST_CASE("groups: false alarms of null studies with four trials per person and an intraclass correlation of 0.8") {
  constexpr int studies = 2000;
  const FalseAlarms participants = false_alarms(studies, true);
  MESSAGE("intervals that leave out 0: " << participants.interval95 << ", any of seven: " << participants.any
                                         << ", adjusted: " << participants.any_adjusted);
  CHECK(within(participants.interval95, 0.05, 4.0 * std::sqrt(0.05 * 0.95 / (7.0 * studies))));
  CHECK(participants.any_adjusted < 0.05 + 4.0 * std::sqrt(0.05 * 0.95 / studies));
  CHECK(participants.any_adjusted >
        0.049 - 4.0 * std::sqrt(0.05 * 0.95 / studies));  // 1 - (1 - 0.05 / 7)^7: not too wide
  // Recordings that do not say whose they are alarm as often as before they were averaged.
  const FalseAlarms trials = false_alarms(200, false);
  MESSAGE("without people: " << trials.interval95 << ", any of seven: " << trials.any
                             << ", adjusted: " << trials.any_adjusted);
  CHECK(trials.interval95 > 0.2);
  CHECK(trials.any > 0.8);
}
