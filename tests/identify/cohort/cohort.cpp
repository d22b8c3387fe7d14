// The hierarchical model: differences, spread, shrinkage, trials, covariates; chains and bits; what is refused.
#include "identify/cohort/cohort.hpp"

#include <doctest/doctest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "identify/cohort/detail/design.hpp"
#include "identify/cohort/detail/sampler.hpp"
#include "tests/helpers.hpp"
#include "tests/identify/cohort/made_up.hpp"
#include "tests/near.hpp"

using decid::Code;
using decid::cohort::Quantity;
using decid::cohort::Recording;
using decid::cohort::Result;
using namespace decid::test;

namespace {

/// Persons of two groups with two parameters, evidence with sd 0.3 about coordinates with sd 0.4 between persons.
std::vector<Recording> study(int participants, double difference, int recordings = 1, double trial_sd = 0.0) {
  Normals normal(3);
  std::vector<Recording> all;
  for (const char* group : {"a", "b"})
    for (int i = 0; i < participants; ++i) {
      const double shift = *group == 'a' ? difference : 0.0;
      const double one = shift + 0.4 * normal(), other = 0.4 * normal();
      for (int t = 0; t < recordings; ++t) {
        const auto measured = [&](double value) { return value + trial_sd * normal() + 0.3 * normal(); };
        const double first = measured(one), second = measured(other);
        all.push_back({group + std::to_string(i), "", group, "", {}, gaussian({first, second}, 0.3)});
      }
    }
  return all;
}

}  // namespace

TEST_CASE("cohort: a difference is found, in units and over the persons' standard deviation") {
  const Result found = analyse(study(40, 0.6), 2);
  REQUIRE(found.comparisons.size() == 1);
  CHECK(found.comparisons[0].participants_in_both == 0);
  const auto& effects = found.comparisons[0].effects;
  const double total = std::sqrt(1.0 + 0.16);
  CHECK(holds(effects[0].difference, decid::normal_distribution(0.6 / total) - 0.5));
  CHECK(effects[0].difference.interval95[0] > 0.0);
  CHECK(holds(effects[0].standardised, 0.6 / 0.4));
  CHECK(effects[0].direction > 0.99);
  CHECK(holds(effects[1].difference, 0.0));
  CHECK(effects[1].direction >= 0.5);
  for (const auto& effect : effects) {
    CHECK(effect.simultaneous95[0] <= effect.difference.interval95[0]);
    CHECK(effect.simultaneous95[1] >= effect.difference.interval95[1]);
  }
  CHECK(holds(found.cells[1].between_sd[1], 0.4 * decid::normal_density(0.0)));
  CHECK(holds(found.variances[1].participant, 0.4 * decid::normal_density(0.0)));
  CHECK(found.variances[1].trial.mean == 0.0);
  CHECK(found.visits.size() == 80);
  CHECK(found.changes.empty());
}

TEST_CASE("cohort: persons differ by parameter and group") {
  Normals normal(6);
  std::vector<Recording> recordings;
  for (const char* group : {"a", "b"})
    for (int i = 0; i < 40; ++i) {
      const double little = 0.1 * normal() + 0.1 * normal(), much = 0.8 * normal() + 0.1 * normal();
      const bool first = *group == 'a';
      recordings.push_back({group + std::to_string(i),
                            "",
                            group,
                            "",
                            {},
                            gaussian({first ? little : much, first ? much : little}, 0.1)});
    }
  const Result found = analyse(recordings, 2);
  REQUIRE(found.cells.size() == 2);
  CHECK(found.cells[0].between_sd[1].mean > 4.0 * found.cells[0].between_sd[0].mean);
  CHECK(found.cells[1].between_sd[0].mean > 4.0 * found.cells[1].between_sd[1].mean);
}

TEST_CASE("cohort: the uncertainty of a recording is the median's, of an even number the mean of the middle two") {
  std::vector<Recording> recordings;
  for (const char* group : {"a", "b"})
    for (int i = 0; i < 4; ++i)
      recordings.push_back(
          {group + std::to_string(i), "", group, "", {}, gaussian({0.05 * (i - 1.5)}, *group == 'a' ? 0.1 : 1.0)});
  // The root of the mean of 0.01 and 1, times at most the normal density's largest value.
  const double found = analyse(recordings, 1).variances.at(0).measurement, highest = 0.3989 * std::sqrt(0.505);
  CHECK(found > 0.85 * highest);
  CHECK(found <= highest);
}

TEST_CASE("cohort: shrinkage is undone") {
  // Evidence of sd 1.5: a network's means keep 1 / (1 + 2.25) = 31% of a difference.
  Normals normal(4);
  std::vector<Recording> recordings;
  for (int i = 0; i < 400; ++i) {
    const bool first = i < 200;
    const double at = (first ? 0.4 : -0.4) + 0.3 * normal() + 1.5 * normal();
    recordings.push_back({std::to_string(i), "", first ? "a" : "b", "", {}, gaussian({at}, 1.5)});
  }
  decid::cohort::Settings settings;
  settings.draws = 400;
  const Quantity difference = analyse(recordings, 1, settings).comparisons[0].effects[0].difference;
  CHECK(holds(difference, 2.0 * decid::normal_distribution(0.4 / std::sqrt(1.09)) - 1.0));
  CHECK(difference.interval95[0] > 0.31 * 0.3);
}

TEST_CASE("cohort: several recordings of a person share the person's level") {
  const Result found = analyse(study(20, 0.0, 4, 0.2), 2);
  CHECK(found.visits.size() == 40);
  CHECK(found.visits[0].recordings == 4);
  CHECK(found.cells[0].recordings == 80);
  CHECK(holds(found.variances[0].trial, 0.2 * decid::normal_density(0.0)));
  CHECK(holds(found.variances[0].participant, 0.4 * decid::normal_density(0.0)));
}

TEST_CASE("cohort: the largest R-hat is that of every quantity") {
  std::vector<Recording> recordings = study(20, 0.0, 4, 0.2);
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    recordings[i].covariates = {static_cast<double>(i % 7)};
    recordings[i].session = i % 2 == 0 ? "1" : "2";
  }
  decid::cohort::Settings settings;
  settings.covariates = {"age"};
  settings.warm_up = 5;
  settings.draws = 40;
  const Result found = analyse(recordings, 2, settings);
  REQUIRE(found.interactions.size() == 1);
  REQUIRE(!found.changes.empty());
  std::vector<double> all;
  const auto add = [&](const Quantity& quantity) { all.push_back(quantity.rhat); };
  for (const decid::cohort::Cell& cell : found.cells)
    for (const auto* list : {&cell.mean, &cell.between_sd}) std::ranges::for_each(*list, add);
  const double of_cells = *std::ranges::max_element(all);
  for (const decid::cohort::VarianceParts& parts : found.variances) {
    CHECK(parts.trial.rhat > 1.0);
    for (const Quantity& part : {parts.participant, parts.visit, parts.trial}) add(part);
  }
  for (const decid::cohort::Slope& slope : found.covariates[0].slopes) add(slope);
  for (const auto& comparison : found.comparisons)
    for (const decid::cohort::Effect& effect : comparison.effects) {
      add(effect.difference);
      add(effect.standardised);
    }
  for (const decid::cohort::Effect& effect : found.interactions[0].effects) {
    add(effect.difference);
    add(effect.standardised);
  }
  for (const decid::cohort::Visit& visit : found.visits) std::ranges::for_each(visit.value, add);
  for (const decid::cohort::Change& change : found.changes) std::ranges::for_each(change.difference, add);
  CHECK(found.max_rhat == *std::ranges::max_element(all));
  CHECK(found.max_rhat >= of_cells);
}

TEST_CASE("cohort: chains begin with standard deviations that are far apart") {
  const std::vector<Recording> recordings = study(4, 0.0, 2, 0.2);
  const decid::cohort::Design design = decid::cohort::make_design(recordings, 2, {});
  std::vector<double> participant, trial;
  for (std::size_t chain = 0; chain < 8; ++chain) {
    const decid::cohort::Draw first = decid::cohort::Sampler(design, recordings, 1, chain).draw();
    participant.push_back(first.participant_sd[0]);
    trial.push_back(first.trial_sd.at(1));
  }
  for (const std::vector<double>& sds : {participant, trial}) {
    const double low = *std::ranges::min_element(sds), high = *std::ranges::max_element(sds);
    CHECK(low >= 0.03);
    CHECK(high <= 0.9);
    CHECK(high > 3.0 * low);
  }
}

TEST_CASE("cohort: a covariate's effect is per unit, and groups are compared at its mean") {
  Normals normal(7);
  std::vector<Recording> recordings;
  decid::cohort::Settings settings;
  settings.covariates = {"age"};
  for (int i = 0; i < 60; ++i) {
    // Persons of "a" are 20 years older; the parameter falls by 0.02 per year and does not depend on the group.
    const bool first = i < 30;
    const double age = (first ? 60.0 : 40.0) + 8.0 * normal();
    const double x = -0.02 * (age - 50.0) + 0.1 * normal() + 0.2 * normal();
    recordings.push_back({std::to_string(i), "", first ? "a" : "b", "", {age}, gaussian({x}, 0.2)});
  }
  const Result found = analyse(recordings, 1, settings);
  REQUIRE(found.covariates.size() == 1);
  CHECK(found.covariates[0].name == "age");
  CHECK(within(found.covariates[0].mean, 50.0, 5.0));
  CHECK(found.covariates[0].unknown == 0);
  CHECK(holds(found.covariates[0].slopes[0], -0.02 * decid::normal_density(0.0)));
  CHECK(found.covariates[0].slopes[0].interval95[1] < 0.0);
  CHECK(found.covariates[0].slopes[0].direction > 0.99);
  CHECK(holds(found.comparisons[0].effects[0].difference, 0.0));
  recordings[3].covariates[0] = std::nan("");  // unknown: the mean
  const decid::cohort::Covariate one_unknown = analyse(recordings, 1, settings).covariates[0];
  CHECK(one_unknown.unknown == 1);
  CHECK(one_unknown.slopes[0].interval95[1] < 0.0);
}

TEST_CASE("cohort: an unknown covariate is the person's in another visit, else the group's mean") {
  const auto made = [](const std::string& participant, const std::string& session, const std::string& group,
                       double age) { return Recording{participant, session, group, "", {age}, gaussian({0.0}, 0.2)}; };
  const double unknown = std::nan("");
  const std::vector<Recording> recordings{made("p", "1", "old", 80.0), made("p", "2", "old", unknown),
                                          made("q", "1", "old", unknown), made("r", "1", "young", 20.0),
                                          made("s", "1", "young", 30.0)};
  decid::cohort::Settings settings;
  settings.covariates = {"age"};
  const decid::cohort::Design design = decid::cohort::make_design(recordings, 1, settings);
  std::vector<double> ages;
  for (const decid::cohort::Design::Visit& visit : design.visits)
    ages.push_back(design.covariate_mean[0] + design.covariate_sd[0] * visit.covariates[0]);
  REQUIRE(ages.size() == 5);
  for (const std::size_t visit : {0U, 1U, 2U}) CHECK(near(ages[visit], 80.0, 1e-12));
  CHECK(near(ages[3], 20.0, 1e-12));
  CHECK(near(ages[4], 30.0, 1e-12));
}

TEST_CASE("cohort: cells are in the order of the numbers in their names") {
  std::vector<Recording> recordings;
  for (const char* month : {"month 12", "month 3", "month 0", "month 6"})
    recordings.push_back({"p", month, "g10", "", {}, gaussian({0.1}, 0.3)});
  recordings.push_back({"q", "month 0", "g9", "", {}, gaussian({0.1}, 0.3)});
  const decid::cohort::Design design = decid::cohort::make_design(recordings, 1, {});
  REQUIRE(design.cells.size() == 5);
  CHECK(design.cells[0].group == "g9");
  CHECK(design.cells[1].session == "month 0");
  CHECK(design.cells[2].session == "month 3");
  CHECK(design.cells[4].session == "month 12");
}

TEST_CASE("cohort: the same bits for any number of threads, others for another seed") {
  const std::vector<Recording> recordings = study(4, 0.3);
  decid::cohort::Settings settings;
  settings.draws = 30;
  settings.warm_up = 10;
  const int threads = omp_get_max_threads();
  std::vector<double> means;
  for (const int count : {1, 3}) {
    omp_set_num_threads(count);
    means.push_back(analyse(recordings, 2, settings).comparisons[0].effects[1].difference.mean);
  }
  omp_set_num_threads(threads);
  settings.seed = 2;
  means.push_back(analyse(recordings, 2, settings).comparisons[0].effects[1].difference.mean);
  CHECK(means[0] == means[1]);
  CHECK(means[0] != means[2]);
}

TEST_CASE("cohort: studies that cannot be analysed are refused") {
  std::vector<Recording> recordings = study(2, 0.0);
  decid::cohort::Settings settings;
  check_error([&] { (void)analyse(std::vector<Recording>{}, 2); }, Code::trials_missing);
  check_error([&] { (void)analyse(recordings, 3); }, Code::size_mismatch);
  settings.draws = 7;
  check_error([&] { (void)analyse(recordings, 2, settings); }, Code::setting_out_of_range);
  settings = {};
  settings.chains = 0;
  check_error([&] { (void)analyse(recordings, 2, settings); }, Code::setting_out_of_range);
  settings = {};
  settings.covariates = {"age"};
  check_error([&] { (void)analyse(recordings, 2, settings); }, Code::size_mismatch);
  for (Recording& one : recordings) one.covariates = {50.0};
  check_error([&] { (void)analyse(recordings, 2, settings); }, Code::value_invalid);  // all of one age
}
