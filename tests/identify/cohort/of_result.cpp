// Groups of a report by the hierarchical model: distributions of networks, draws of fits, priors, reliability.
#include "identify/cohort/of_result.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "identify/cohort/detail/to_measurement.hpp"
#include "identify/result.hpp"
#include "sim/body_model.hpp"
#include "tests/helpers.hpp"
#include "tests/near.hpp"
#include "tests/posterior/sampling/set_posterior.hpp"

using Without = std::vector<decid::cohort::WithoutEvidence>;
using decid::GroupTable;
using decid::ParameterDistribution;
using decid::RecordingResult;
using decid::Report;
using namespace decid::test;

namespace {

/// A recording with a network's distribution: every coordinate of its posterior is N(at, 0.6^2).
RecordingResult read_by_network(const Report& report, double at) {
  const decid::sim::ParameterTable ranges = report.ranges();
  const std::size_t count = ranges.size();
  std::vector<double> outputs{0.0};
  outputs.resize(1 + count, at);
  outputs.resize(1 + 2 * count, -std::log(0.6));
  outputs.resize(decid::mixture_outputs(1, count), 0.0);
  RecordingResult made;
  made.estimate.distribution = ParameterDistribution(decid::Mixture(1, count, outputs), ranges);
  made.estimate.parameters = decid::sim::Parameters(count);
  for (std::size_t p = 0; p < count; ++p)
    made.estimate.parameters[p] = made.estimate.distribution->mean(static_cast<int>(p));
  return made;
}

RecordingResult fitted(const Report& report, double at, std::size_t draws = 64) {
  const decid::sim::ParameterTable ranges = report.ranges();
  const decid::Random random(2, decid::Stream::user, 0);
  std::vector<decid::posterior::State> states;
  for (std::size_t i = 0; i < draws; ++i) {
    std::vector<double> fractions;
    for (std::size_t p = 0; p < ranges.size(); ++p)
      fractions.push_back(decid::normal_distribution(at + 0.3 * random.normal(i * ranges.size() + p)));
    decid::sim::Parameters& values = states.emplace_back().parameters;
    values = ranges.from_unit(fractions);
    if (!report.fit) continue;
    for (const decid::posterior::ParameterPrior& prior : report.fit->priors.parameters)
      for (std::size_t p = 0; p < ranges.size(); ++p)
        if (prior.fixed && prior.name == ranges[p].name) values[p] = *prior.fixed;
  }
  RecordingResult made = read_by_network(report, 0.0);
  set_posterior(made.fit.emplace().posterior, states, {}, {});
  return made;
}

/// A report with three persons in each of two groups.
struct TwoGroups {
  Report report;
  GroupTable table{"subject", {}};
  explicit TwoGroups(bool same_participants) {
    for (const bool second : {false, true})
      for (int i = 0; i < 3; ++i) {
        report.recordings.push_back(read_by_network(report, 0.2 * i + (second ? 0.5 : -0.5) + 0.01 * i * i));
        table.members.push_back({second ? "b" : "a", (second && !same_participants ? "x" : "y") + std::to_string(i)});
      }
  }
  decid::GroupReport compared() const { return decid::report_groups(table, report); }
};

}  // namespace

TEST_CASE("cohort: groups of a report are analysed by their distributions") {
  TwoGroups made(false);
  const decid::GroupReport groups = made.compared();
  REQUIRE(groups.hierarchical);
  REQUIRE(groups.hierarchical->comparisons.size() == 1);
  CHECK(groups.hierarchical->cells[0].group == "a");
  CHECK(groups.hierarchical->cells[1].participants == 3);
  const decid::cohort::Effect& effect = groups.hierarchical->comparisons[0].effects[decid::sim::Delay];
  // In seconds, larger than the difference of the posteriors' means, which shrink towards the middle.
  const double of_means = groups.comparison.pairs[0].parameters[decid::sim::Delay].difference;
  CHECK(of_means < -0.05);
  CHECK(effect.difference.mean < of_means);
  CHECK(effect.difference.mean > -0.24);
  REQUIRE(groups.reliability.size() == 1);
  CHECK(groups.reliability[0].empty());
}

TEST_CASE("cohort: recordings without a distribution over the ranges are not in the hierarchical model") {
  TwoGroups made(false);
  Report& report = made.report;
  report.recordings[0].estimate.distribution.reset();
  REQUIRE(made.compared().hierarchical);
  CHECK(made.compared().hierarchical->cells[0].participants == 2);
  CHECK(made.compared().without_distribution == Without{{0, "no_distribution"}});
  report.recordings[1].estimate.distribution.reset();  // one person is left
  CHECK_FALSE(made.compared().hierarchical);

  CHECK(decid::cohort::to_measurement(report.recordings[2], report));
  report.fit.emplace().priors.parameters = {{"delay", decid::posterior::ParameterPrior::Range{0.0, 0.2}, {}}};
  CHECK_FALSE(decid::cohort::to_measurement(report.recordings[2], report));
}

TEST_CASE("cohort: each recording that the hierarchical model cannot use has its reason") {
  using decid::posterior::ParameterPrior;
  TwoGroups made(false);
  Report& report = made.report;
  report.fit.emplace().priors.parameters = {{"Kp", ParameterPrior::Range{300.0, 1500.0}, {}}};
  for (std::size_t i = 0; i < 6; ++i) report.recordings[i] = fitted(report, 0.1 * static_cast<double>(i));
  CHECK(made.compared().without_distribution.empty());
  // A stiffness's range in N m/rad is another one over m g h for a heavier body; a range of the delay is not.
  decid::ReportSetting& heavier = report.other_settings.emplace_back();
  heavier.protocol = report.protocol;
  heavier.protocol.experiment.body.mass_kg *= 1.2;
  report.recordings[1].setting = 1;
  report.recordings[4] = fitted(report, 0.4, 15);
  CHECK(made.compared().without_distribution == Without{{1, "other_ranges"}, {4, "few_draws"}});
  CHECK(made.compared().hierarchical);
  report.fit->priors.parameters = {{"delay", ParameterPrior::Range{0.0, 0.2}, {}}};
  CHECK(made.compared().without_distribution == Without{{4, "few_draws"}});
  report.fit->priors.parameters = {{.name = "Kp", .range = {{0.4, 1.8}}, .over_mgh = {.range = true}}};
  CHECK(made.compared().without_distribution == Without{{4, "few_draws"}});  // the same range over m g h
  // Far from a narrow prior a few draws would have all the weight; draws that are all alike are on a plane.
  report.fit->priors.parameters = {{"Kp", {}, ParameterPrior::Normal{700.0, 60.0}}};
  for (std::size_t i = 0; i < 6; ++i) report.recordings[i] = fitted(report, i == 2 ? 0.4 : -0.6);
  const Without narrow = made.compared().without_distribution;
  CHECK(std::ranges::count(narrow, decid::cohort::WithoutEvidence{2, "narrow_prior"}) == 1);
}

TEST_CASE("cohort: fixed parameters are not compared, by no model and no reliability") {
  using decid::posterior::ParameterPrior;
  constexpr std::size_t delay = 5;  // its place among the others
  TwoGroups made(true);
  Report& report = made.report;
  report.fit.emplace().priors.parameters = {{.name = "Kp", .fixed = 839.0}};
  for (std::size_t i = 0; i < 6; ++i) {
    const double at = 0.2 * static_cast<double>(i % 3) + (i < 3 ? -0.5 : 0.5);
    const decid::sim::Parameters values = report.recordings[i].estimate.parameters;
    report.recordings[i] = fitted(report, at);
    report.recordings[i].estimate.parameters = values;
    report.recordings[i].estimate.parameters[decid::sim::Kp] = 839.0;
  }
  CHECK(report.fixed_parameters() == std::vector<std::string>{"Kp"});
  CHECK(report.inferred_parameters() == std::vector<std::size_t>{1, 2, 3, 4, 5, 6});
  CHECK(report.compared_parameters()[delay].name == "delay");
  const decid::GroupReport groups = made.compared();
  CHECK(groups.comparison.intervals == 6);
  REQUIRE(groups.comparison.pairs.size() == 1);
  REQUIRE(groups.comparison.pairs[0].parameters.size() == 6);
  CHECK(groups.comparison.groups[0].parameters.size() == 6);
  const double difference = groups.comparison.pairs[0].parameters[delay].difference;
  CHECK(difference < -0.05);
  CHECK(difference > -0.24);  // s
  REQUIRE(groups.hierarchical);
  REQUIRE(groups.hierarchical->comparisons[0].effects.size() == 6);
  CHECK(groups.hierarchical->variances.size() == 6);
  CHECK(groups.hierarchical->comparisons[0].effects[delay].difference.mean < -0.05);
  CHECK(groups.hierarchical->comparisons[0].effects[0].difference.mean < -20.0);  // Kd, of 125 to 378 N m s/rad
  REQUIRE(groups.reliability.size() == 1);
  REQUIRE(groups.reliability[0].size() == 6);
  CHECK(groups.reliability[0][delay].has_value());
}

TEST_CASE("reliability: a normal prior counts with its standard deviation within the range") {
  using decid::posterior::ParameterPrior;
  const auto shown_with = [](std::optional<ParameterPrior::Normal> normal) {
    TwoGroups made(true);
    made.report.fit.emplace();
    for (std::size_t i = 0; i < 6; ++i) {
      const decid::sim::Parameters values = made.report.recordings[i].estimate.parameters;
      made.report.recordings[i] = fitted(made.report, 0.2 * static_cast<double>(i % 3) + (i < 3 ? -0.5 : 0.5));
      made.report.recordings[i].estimate.parameters = values;
    }
    if (normal) made.report.fit->priors.parameters = {{"delay", {}, normal}};
    const decid::GroupReport groups = made.compared();
    REQUIRE(groups.reliability.size() == 1);
    return groups.reliability[0].at(decid::sim::Delay).value();
  };
  const decid::sim::ParameterInfo delay = Report{}.ranges()[decid::sim::Delay];
  const double middle = 0.5 * (delay.low + delay.high);
  const decid::cohort::Reliability uniform = shown_with({}),
                                   wide = shown_with(ParameterPrior::Normal{middle, 10.0 * delay.range()}),
                                   narrow = shown_with(ParameterPrior::Normal{middle, 0.15 * delay.range()});
  CHECK(uniform.shown_fraction < 0.95);
  CHECK(near(wide.shown_fraction, uniform.shown_fraction, 1e-3));
  CHECK(near(wide.measurement_sd, uniform.measurement_sd, 1e-3));
  CHECK(narrow.shown_fraction < uniform.shown_fraction - 0.05);
}

TEST_CASE(
    "cohort: the range of a fixed parameter may differ between recordings, the range of an inferred one may not") {
  TwoGroups made(false);
  Report& report = made.report;
  decid::sim::BodyModel wider = *report.protocol.experiment.body_model;
  std::vector<decid::sim::ParameterInfo> table(wider.parameters.begin(), wider.parameters.end());
  table[decid::sim::Kp].high *= 1.5;
  wider.parameters = decid::sim::ParameterTable(table);
  report.other_settings.emplace_back().protocol = report.protocol;
  report.other_settings.back().protocol.experiment.body_model = &wider;
  report.fit.emplace().priors.parameters = {{.name = "Kp", .fixed = 839.0}};
  RecordingResult with_kp_fixed = fitted(report, 0.4);
  with_kp_fixed.setting = 1;
  CHECK(decid::cohort::to_measurement(with_kp_fixed, report));
  report.fit->priors.parameters = {{.name = "Kd", .fixed = 250.0}};
  RecordingResult with_kd_fixed = fitted(report, 0.4);
  with_kd_fixed.setting = 1;
  CHECK_FALSE(decid::cohort::to_measurement(with_kd_fixed, report));
}

TEST_CASE(
    "cohort: a network's distribution is no evidence beside a fixed parameter; nothing is left if all are fixed") {
  TwoGroups made(false);
  Report& report = made.report;
  report.fit.emplace().priors.parameters = {{.name = "Kp", .fixed = 839.0}};
  CHECK_FALSE(decid::cohort::to_measurement(report.recordings[0], report));
  CHECK(made.compared().without_distribution.size() == 6);
  for (const std::string& name : report.protocol.parameters().names())
    if (name != "Kp") report.fit->priors.parameters.push_back({.name = name, .fixed = 0.1});
  CHECK(report.inferred_parameters().empty());
  check_error([&] { made.compared(); }, decid::Code::setting_conflict, "fixed");
}

TEST_CASE("cohort: recordings fitted together count once; those of another body are not in the model") {
  TwoGroups made(false);
  auto& [report, table] = made;
  for (const std::size_t twin : {0U, 1U, 2U}) {
    report.recordings.push_back(report.recordings[twin]);
    table.members.push_back(table.members[twin]);
  }
  CHECK(made.compared().hierarchical->cells[0].recordings == 6);
  report.fit.emplace();
  for (const std::size_t twin : {0U, 1U, 2U})
    for (const std::size_t i : {twin, twin + 6}) {
      report.recordings[i] = fitted(report, 0.2 * static_cast<double>(twin) - 0.5);
      report.recordings[i].fit->joint = decid::JointFit{{std::to_string(twin), "twin"}, {}, {}};
    }
  CHECK(made.compared().hierarchical->cells[0].recordings == 3);
  CHECK(made.compared().comparison.groups[0].recordings == 3);
  // A recording of the same person with a fit of its own has the weight of both.
  report.recordings.push_back(report.recordings[0]);
  table.members.push_back(table.members[0]);
  RecordingResult& alone = report.recordings.back();
  alone.fit->joint.reset();
  alone.estimate.parameters[decid::sim::Delay] += 0.03;
  const auto mean_delay = [&] { return made.compared().comparison.groups[0].parameters[decid::sim::Delay].mean; };
  const double with_alone = mean_delay();
  alone.estimate.parameters[decid::sim::Delay] -= 0.03;
  CHECK(near(with_alone - mean_delay(), 0.03 / 2 / 3, 1e-9));
  report.recordings.pop_back();
  table.members.pop_back();
  // Where the chains were far apart, each has the network's answer for itself.
  for (RecordingResult& one : report.recordings)
    if (one.fit) one.fit->answer = decid::FitFigures::Answer::network;
  CHECK(made.compared().hierarchical->cells[0].recordings == 6);

  decid::ReportSetting& other = report.other_settings.emplace_back();
  other.protocol = report.protocol;
  report.recordings[5].setting = 1;
  CHECK(decid::cohort::to_measurement(report.recordings[5], report));  // the same body
  other.protocol.experiment.body.mass_kg *= 1.2;
  CHECK_FALSE(decid::cohort::to_measurement(report.recordings[5], report));  // a network's ranges are its body's
  // Draws of a heavier body have the same fractions of their own ranges.
  report.fit.emplace();
  RecordingResult own = fitted(report, 0.4);
  Report heavier = report;
  heavier.protocol = other.protocol;
  RecordingResult scaled = fitted(heavier, 0.4);
  scaled.setting = 1;
  const auto one = decid::cohort::to_measurement(own, report), same = decid::cohort::to_measurement(scaled, report);
  REQUIRE(same);
  CHECK(near(same->centre(0, decid::sim::Kp), one->centre(0, decid::sim::Kp), 1e-9));
}

TEST_CASE("cohort: people of other bodies are compared at one body's m g h") {
  TwoGroups made(false);
  auto& [report, table] = made;
  report.protocol.experiment.body.mass_kg *= 0.8;
  Report heavier = report;
  heavier.protocol.experiment.body.mass_kg *= 1.5;
  report.body_assumed = false;
  report.other_settings.push_back({heavier.protocol, true, {}});
  // The same controllers relative to gravity in both groups.
  for (std::size_t i = 0; i < 3; ++i) {
    report.recordings[i] = read_by_network(report, 0.2 * static_cast<double>(i));
    report.recordings[i + 3] = read_by_network(heavier, 0.2 * static_cast<double>(i));
    report.recordings[i + 3].setting = 1;
  }
  const decid::GroupReport groups = made.compared();
  const double mgh = decid::sim::Body{}.mgh(), own = report.protocol.experiment.body.mgh();
  CHECK(groups.bodies_differ);
  CHECK(groups.assumed_bodies == 3);
  CHECK(groups.mgh_nm_rad == mgh);
  const decid::GroupPair& pair = groups.comparison.pairs.at(0);
  for (const decid::GroupEffect& effect : pair.parameters) CHECK(std::abs(effect.difference) < 1e-9);
  const double kp = report.recordings[1].estimate.parameters[decid::sim::Kp];
  CHECK(groups.comparison.groups[0].parameters[decid::sim::Kp].mean > 1.1 * kp);  // 0.8 of the posture model's mass
  REQUIRE(groups.hierarchical);
  const double middle = groups.hierarchical->cells[0].mean[decid::sim::Kp].mean;
  CHECK(middle > 0.6 * mgh);
  CHECK(middle < 1.5 * mgh);

  // Reliability of values over m g h: of two visits of other bodies.
  std::vector<decid::cohort::Recording> members;
  for (const decid::GroupMember& member : table.members)
    members.push_back({member.participant.substr(1), {}, member.group, {}, {}, {}});
  const auto scaled = decid::cohort::compute_reliability(report, members, "a", "b", mgh),
             unscaled = decid::cohort::compute_reliability(report, members, "a", "b");
  REQUIRE(scaled[decid::sim::Kp]);
  CHECK(scaled[decid::sim::Kp]->visit_sd < 1e-6);
  CHECK(unscaled[decid::sim::Kp]->visit_sd > 10.0);

  // One body: values stay as they are.
  for (std::size_t i = 3; i < 6; ++i) report.recordings[i] = read_by_network(report, 0.2 * static_cast<double>(i));
  const decid::GroupReport same = made.compared();
  CHECK_FALSE(same.bodies_differ);
  CHECK(same.mgh_nm_rad == own);
  double sum = 0.0;
  for (std::size_t i = 0; i < 3; ++i) sum += report.recordings[i].estimate.parameters[decid::sim::Kp];
  CHECK(same.comparison.groups[0].parameters[decid::sim::Kp].mean == sum / 3.0);
}

TEST_CASE("cohort: draws of a fit are evidence, and a normal prior is taken back") {
  Report report;
  report.fit.emplace();
  const RecordingResult fit = fitted(report, 0.4);
  const auto uniform = decid::cohort::to_measurement(fit, report);
  REQUIRE(uniform);
  const auto centre = [](const decid::cohort::Measurement& measurement) {
    double sum = 0.0, whole = 0.0;
    for (std::size_t k = 0; k < measurement.components(); ++k) {
      const double weight = std::exp(measurement.log_weight(k));
      sum += weight * measurement.centre(k, decid::sim::Kp);
      whole += weight;
    }
    return sum / whole;
  };
  // Under a prior below the draws they were drawn downwards: without it the evidence is higher.
  report.fit->priors.parameters = {{"Kp", {}, decid::posterior::ParameterPrior::Normal{700.0, 300.0}}};
  const auto taken_back = decid::cohort::to_measurement(fit, report);
  REQUIRE(taken_back);
  CHECK(centre(*taken_back) > centre(*uniform) + 0.05);
}

TEST_CASE("cohort: one person's change has the interval of both recordings, without a hierarchical model") {
  TwoGroups made(true);
  auto& [report, table] = made;
  for (std::size_t i = 1; i < 6; ++i)
    if (i != 3) table.members[i].group.clear();  // y0 is left, once in each group
  decid::GroupReport groups = made.compared();
  CHECK_FALSE(groups.hierarchical);
  REQUIRE(groups.reliability.size() == 1);
  CHECK(groups.reliability[0].empty());
  REQUIRE(groups.own_changes.size() == 1);
  CHECK(groups.own_changes[0].participant == "y0");
  CHECK(groups.own_changes[0].first == "a");
  REQUIRE(groups.own_changes[0].difference.size() == 7);
  const decid::cohort::Quantity change = groups.own_changes[0].difference[decid::sim::Delay];
  CHECK(near(change.mean, groups.comparison.pairs[0].parameters[decid::sim::Delay].difference, 1e-12));
  const ParameterDistribution &one = *report.recordings[0].estimate.distribution,
                              &other = *report.recordings[3].estimate.distribution;
  const int delay = decid::sim::Delay;
  CHECK(near(change.sd, std::hypot(one.stddev(delay), other.stddev(delay)), 1e-12));
  // The distribution of the difference is skewed: all differences of many quantiles have its interval.
  std::vector<double> differences;
  constexpr int levels = 300;
  for (int i = 0; i < levels; ++i)
    for (int k = 0; k < levels; ++k)
      differences.push_back(one.quantile(delay, (i + 0.5) / levels) - other.quantile(delay, (k + 0.5) / levels));
  std::ranges::sort(differences);
  CHECK(within(change.interval95[0], differences[differences.size() / 40], 0.02 * change.sd));
  CHECK(within(change.interval95[1], differences[differences.size() * 39 / 40], 0.02 * change.sd));
  CHECK_FALSE(decid::cohort::excludes_zero(change));
  CHECK_FALSE(groups.own_changes[0].has_caution);
  decid::add_warning(report.recordings[1].warnings, decid::Severity::caution, "slow_sway", "of another person");
  CHECK_FALSE(made.compared().own_changes.at(0).has_caution);
  decid::add_warning(report.recordings[3].warnings, decid::Severity::caution, "slow_sway", "of this person");
  CHECK(made.compared().own_changes.at(0).has_caution);
  // Four recordings per visit halve the standard deviation.
  for (int more = 0; more < 3; ++more)
    for (const std::size_t i : {std::size_t{0}, std::size_t{3}}) {
      report.recordings.push_back(report.recordings[i]);
      table.members.push_back(table.members[i]);
    }
  groups = made.compared();
  REQUIRE(groups.own_changes.size() == 1);
  const decid::cohort::Quantity four = groups.own_changes[0].difference[decid::sim::Delay];
  CHECK(near(four.sd, 0.5 * change.sd, 1e-12));
  CHECK(within(four.interval95[1] - four.interval95[0], 3.92 * four.sd, 0.1 * four.sd));
  CHECK(decid::cohort::excludes_zero(four));
  // A recording without a distribution says nothing of its uncertainty.
  for (std::size_t i = 0; i < report.recordings.size(); ++i)
    if (table.members[i].group == "b") report.recordings[i].estimate.distribution.reset();
  CHECK(made.compared().own_changes.empty());
}

TEST_CASE("cohort: sessions and covariates of a report's persons") {
  TwoGroups made(false);
  for (std::size_t i = 0; i < 6; ++i) {  // once more, a year later
    made.report.recordings.push_back(read_by_network(made.report, 0.2 * static_cast<double>(i % 3) + 0.4));
    made.table.members.push_back(made.table.members[i]);
    made.table.members[i].session = "1";
    made.table.members.back().session = "2";
  }
  decid::GroupReport groups = made.compared();
  REQUIRE(groups.comparison.groups.size() == 4);
  CHECK(groups.comparison.groups[1].name == "a, 2");
  REQUIRE(groups.comparison.pairs.size() == 4);
  CHECK(groups.comparison.intervals == 28);
  CHECK(groups.comparison.pairs[0].paired);
  CHECK(groups.comparison.pairs[0].first == 1);  // the later session minus the earlier one
  CHECK(groups.comparison.pairs[0].parameters[decid::sim::Delay].difference > 0.0);
  CHECK(groups.comparison.pairs[1].first == 0);  // groups: in the order of their names
  CHECK_FALSE(groups.comparison.pairs[1].paired);
  REQUIRE(groups.hierarchical);
  CHECK(groups.hierarchical->comparisons.size() == 4);
  CHECK(groups.hierarchical->interactions.size() == 1);
  CHECK(groups.hierarchical->changes.size() == 6);
  REQUIRE(groups.reliability.size() == 4);
  CHECK(groups.reliability[0].size() == 7);
  CHECK(groups.reliability[1].empty());

  made.table.covariates = {"age"};
  for (std::size_t i = 0; i < 12; ++i) made.table.members[i].covariates = {50.0 + static_cast<double>(i % 3)};
  groups = made.compared();
  REQUIRE(groups.hierarchical);
  REQUIRE(groups.hierarchical->covariates.size() == 1);
  CHECK(groups.hierarchical->covariates[0].mean == 51.0);
  CHECK(groups.hierarchical->covariates[0].slopes[decid::sim::Delay].mean > 0.0);
  for (decid::GroupMember& member : made.table.members) member.covariates = {50.0};
  CHECK_FALSE(made.compared().hierarchical);  // the covariate has one value
  // One group suffices for a covariate.
  for (std::size_t i = 0; i < 12; ++i) {
    made.table.members[i].covariates = {static_cast<double>(i)};
    made.table.members[i].session.clear();
    if (i % 6 > 2) made.table.members[i].group.clear();
  }
  groups = made.compared();
  CHECK(groups.comparison.pairs.empty());
  CHECK(groups.comparison.intervals == 0);
  REQUIRE(groups.hierarchical);
  CHECK(groups.hierarchical->cells.size() == 1);
  CHECK(groups.hierarchical->covariates.size() == 1);
}

TEST_CASE("cohort: persons in both groups have a reliability and changes") {
  TwoGroups made(true);
  Report& report = made.report;
  const decid::GroupReport groups = made.compared();
  REQUIRE(groups.hierarchical);
  CHECK(groups.hierarchical->comparisons[0].participants_in_both == 3);
  CHECK(groups.hierarchical->changes.size() == 3);
  REQUIRE(groups.own_changes.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const decid::cohort::Change& change = groups.hierarchical->changes[i];
    REQUIRE(change.own.size() == 7);
    CHECK(groups.hierarchical->visits[change.first].participant == groups.own_changes[i].participant);
    CHECK(change.own[0].interval95 == groups.own_changes[i].difference[0].interval95);
  }
  REQUIRE(groups.reliability.size() == 1);
  REQUIRE(groups.reliability[0].size() == 7);
  REQUIRE(groups.reliability[0][0]);
  CHECK(groups.reliability[0][0]->participants == 3);
  const decid::cohort::Reliability& kp = *groups.reliability[0][0];
  CHECK(kp.measurement_sd > 0.0);
  // The values are means of posteriors: they show a part of a change, and vary by as much less.
  const double shown = 1.0 - std::pow(report.recordings[0].estimate.distribution->stddev(0) /
                                          (report.ranges()[0].range() / std::sqrt(12.0)),
                                      2);
  CHECK(within(kp.shown_fraction, shown, 0.05));
  CHECK(kp.measurement_sd < report.recordings[0].estimate.distribution->stddev(0));
  for (RecordingResult& one : report.recordings) one.estimate.parameters[0] = 900.0;
  CHECK_FALSE(made.compared().reliability[0][0]);
}
