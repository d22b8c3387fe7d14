// The hierarchical model: against numerical integration; pairs, trials, covariates, changes; the same bits.
#include "identify/cohort/cohort.hpp"

#include <doctest/doctest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "identify/cohort/detail/design.hpp"
#include "identify/cohort/detail/sampler.hpp"
#include "tests/helpers.hpp"
#include "tests/identify/cohort/made_up.hpp"
#include "tests/near.hpp"

using decid::Code;
using decid::Random;
using decid::Stream;
using decid::cohort::Quantity;
using decid::cohort::Recording;
using decid::cohort::Result;
using namespace decid::test;

namespace {

/// The population's mean, as a fraction: expectation and standard deviation under the exact posterior, by a grid over
/// the mean and the standard deviation of coordinates, from the evidence's likelihood of both.
std::array<double, 2> by_grid(double noise_variance, const std::function<double(double, double)>& log_likelihood) {
  double whole = 0.0, sum = 0.0, squares = 0.0;
  for (int i = 0; i < 800; ++i)
    for (int j = 0; j < 300; ++j) {
      const double mean = -4.0 + 0.01 * (i + 0.5), log_sd = std::log(0.001) * (1.0 - (j + 0.5) / 300.0);
      const double variance = std::exp(2.0 * log_sd);
      const double log_prior = -0.5 * mean * mean + log_sd - 0.5 * std::log(variance + noise_variance);
      const double weight = std::exp(log_prior + log_likelihood(mean, variance));
      const double value = decid::normal_distribution(mean / std::sqrt(1.0 + variance));
      whole += weight;
      sum += weight * value;
      squares += weight * value * value;
    }
  return {sum / whole, std::sqrt(squares / whole - sum * sum / whole / whole)};
}

double log_normal(double off, double variance) {
  return -0.5 * (off * off / variance + std::log(variance));
}

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

/// Four standard deviations: about one seed in 10,000 fails.
bool holds(const Quantity& quantity, double value) {
  return std::abs(quantity.mean - value) <= 4.0 * quantity.sd;
}

}  // namespace

TEST_CASE("cohort: a group's mean is that of the exact posterior") {
  const std::vector<double> all_at{-0.5, 0.9, 0.4, 0.1, 0.2}, all_sd{0.3, 0.2, 0.5, 0.8, 0.4};
  for (const std::size_t participants : {std::size_t{2}, std::size_t{5}}) {
    CAPTURE(participants);
    const std::span<const double> at = std::span(all_at).first(participants),
                                  sd = std::span(all_sd).first(participants);
    std::vector<Recording> recordings;
    double precision = 0.0;
    for (std::size_t i = 0; i < participants; ++i) {
      recordings.push_back({std::to_string(i), "", "", "", {}, gaussian({at[i]}, sd[i])});
      precision += 1.0 / (sd[i] * sd[i]) / static_cast<double>(participants);
    }
    const std::array<double, 2> exact = by_grid(1.0 / precision, [&](double centre, double variance) {
      double sum = 0.0;
      for (std::size_t i = 0; i < participants; ++i) sum += log_normal(at[i] - centre, variance + sd[i] * sd[i]);
      return sum;
    });
    const Result found = analyse(recordings, 1);
    const double mean = exact[0], stddev = exact[1];
    CAPTURE(mean);
    CAPTURE(stddev);
    REQUIRE(found.cells.size() == 1);
    CHECK(found.cells[0].participants == participants);
    // 6,000 draws, at least 1,500 of them effective: four standard errors.
    CHECK(within(found.cells[0].mean[0].mean, mean, 4.0 * stddev / std::sqrt(1500.0)));
    CHECK(near(found.cells[0].mean[0].sd, stddev, 4.0 / std::sqrt(2.0 * 1500.0)));
    CHECK(found.max_rhat < 1.05);
    CHECK(found.comparisons.empty());
  }
}

TEST_CASE("cohort: the standard deviation of persons that are known exactly is that of the exact posterior") {
  // So precise that only the move given the deviations goes far.
  const std::vector<double> at{-0.5, 0.9, 0.4};
  const double precision = 1e4, noise_variance = 1.0 / precision;
  std::vector<Recording> recordings;
  for (const double value : at)
    recordings.push_back({std::to_string(value), "", "", "", {}, gaussian({value}, std::sqrt(noise_variance))});
  double whole = 0.0, sum = 0.0, squares = 0.0;
  for (int i = 0; i < 700; ++i)
    for (int j = 0; j < 400; ++j) {
      const double centre = -3.5 + 0.01 * (i + 0.5), log_sd = -4.0 * (1.0 - (j + 0.5) / 400.0);
      const double variance = std::exp(2.0 * log_sd) + noise_variance;
      double log_weight = -0.5 * centre * centre + log_sd - 0.5 * std::log(variance);
      for (const double value : at) log_weight += log_normal(value - centre, variance);
      const double weight = std::exp(log_weight);
      whole += weight;
      sum += weight * log_sd;
      squares += weight * log_sd * log_sd;
    }
  const double mean = sum / whole, stddev = std::sqrt(squares / whole - mean * mean);
  const decid::cohort::Design design = decid::cohort::make_design(recordings, 1, {});
  double found = 0.0;
  constexpr int chains = 4, sweeps = 4000;
  for (std::size_t chain = 0; chain < chains; ++chain) {
    decid::cohort::Sampler sampler(design, recordings, 1, chain);
    for (int i = 0; i < 200; ++i) sampler.sweep();
    for (int i = 0; i < sweeps; ++i) {
      sampler.sweep();
      found += std::log(sampler.draw().participant_sd[0]) / (chains * sweeps);
    }
  }
  CAPTURE(mean);
  CAPTURE(stddev);
  // At least one effective draw of four; one person too many would add 0.3 standard deviations.
  CHECK(within(found, mean, 4.0 * stddev / std::sqrt(chains * sweeps / 4.0)));
}

TEST_CASE("cohort: evidence with two modes, from draws, is that of the exact posterior") {
  // Under its uniform prior a recording has modes at -1 and 1 of sd 0.2; three others are precise, near 0.8.
  const Random random(8, Stream::user, 1);
  std::vector<double> draws;
  for (std::uint64_t i = 0; i < 4096; ++i)
    draws.push_back(decid::normal_distribution((i / 16 % 2 == 0 ? -1.0 : 1.0) + 0.2 * random.normal(i)));
  std::vector<Recording> recordings{{"x", "", "", "", {}, decid::cohort::Measurement::of_draws(1, draws)}};
  const std::vector<double> at{0.7, 0.8, 0.9};
  double precision = 1.0 / recordings[0].measurement.variance(0);
  for (const double value : at) {
    recordings.push_back({std::to_string(value), "", "", "", {}, gaussian({value}, 0.1)});
    precision += 100.0;
  }
  // Evidence of a mode: precision 25 - 1, mean 25 m / 24; both modes weigh the same.
  const std::array<double, 2> exact = by_grid(4.0 / precision, [&](double centre, double variance) {
    double sum = 0.0;
    for (const double value : at) sum += log_normal(value - centre, variance + 0.01);
    const double wide = variance + 1.0 / 24.0, below = log_normal(-25.0 / 24.0 - centre, wide);
    return sum + std::log(std::exp(below) + std::exp(log_normal(25.0 / 24.0 - centre, wide)));
  });
  const Result found = analyse(recordings, 1);
  const double mean = exact[0], stddev = exact[1];
  CAPTURE(mean);
  CAPTURE(stddev);
  CHECK(within(found.cells[0].mean[0].mean, mean, 0.15 * stddev));
  CHECK(near(found.cells[0].mean[0].sd, stddev, 0.15));
}

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

TEST_CASE("cohort: persons in two sessions are compared in pairs, and their changes have intervals") {
  Normals normal(6);
  std::vector<Recording> recordings;
  for (int i = 0; i < 15; ++i) {
    const double own = 0.8 * normal();
    const double change = i == 0 ? 1.2 : 0.25 + 0.05 * normal();
    for (const bool second : {false, true})
      recordings.push_back({"p" + std::to_string(i),
                            second ? "2" : "1",
                            "all",
                            "",
                            {},
                            gaussian({own + (second ? change : 0.0) + 0.1 * normal()}, 0.1)});
  }
  const Result found = analyse(recordings, 1);
  REQUIRE(found.comparisons.size() == 1);
  CHECK(found.comparisons[0].participants_in_both == 15);
  const Quantity& difference = found.comparisons[0].effects[0].difference;
  CHECK(difference.interval95[0] > 0.0);  // the later session minus the earlier one
  CHECK(found.cells[found.comparisons[0].first].session == "2");
  // An unpaired comparison would have 0.8 phi sqrt(2 / 15) = 0.11 for its standard deviation.
  CHECK(difference.sd < 0.06);
  REQUIRE(found.changes.size() == 15);
  CHECK(found.changes[0].changed(0));
  CHECK(found.changes[0].difference[0].mean > 0.0);
  CHECK(found.visits[found.changes[0].first].participant == "p0");
  CHECK(found.variances[0].visit.mean > 0.0);
}

TEST_CASE("cohort: the later of two sessions, also by words") {
  using decid::cohort::second_is_later;
  for (const auto& [first, second] : {std::pair("1", "2"),
                                      {"T1", "T2"},
                                      {"2024-03-31", "2024-05-01"},
                                      {"pre", "week 6"},
                                      {"baseline", "follow-up"},
                                      {"test", "retest"},
                                      {"Eingang", "Ausgang"},
                                      {"post 1", "post 2"}})
    CHECK(second_is_later(first, second));
  for (const auto& [first, second] : {std::pair("post", "pre"),
                                      {"after", "Before"},
                                      {"Nachher", "Vorher"},
                                      {"follow-up", "pre"},
                                      {"fu1", "t0"},
                                      {"retest", "test"},
                                      {"Entlassung", "Aufnahme"},
                                      {"month 3", "pre"}})
    CHECK_FALSE(second_is_later(first, second));
}

TEST_CASE("cohort: how much more one group changes is the difference of two differences") {
  Normals normal(9);
  std::vector<Recording> recordings;
  for (const char* group : {"a", "b"})
    for (int i = 0; i < 20; ++i) {
      const double own = 0.4 * normal();
      for (const bool second : {false, true}) {
        const double change = second && *group == 'a' ? 0.5 : 0.0;
        recordings.push_back({group + std::to_string(i),
                              second ? "2" : "1",
                              group,
                              "",
                              {},
                              gaussian({own + change + 0.1 * normal()}, 0.1)});
      }
    }
  const Result found = analyse(recordings, 1);
  REQUIRE(found.cells.size() == 4);
  CHECK(found.cells[1].name() == "a, 2");
  CHECK(decid::cohort::cell_name(decid::cohort::everyone, "2", "") == "2");
  CHECK(decid::cohort::cell_name(decid::cohort::everyone, "", "") == decid::cohort::everyone);
  REQUIRE(found.comparisons.size() == 4);  // not a, 1 with b, 2
  REQUIRE(found.interactions.size() == 1);
  CHECK(found.interactions[0].first == 0);
  CHECK(found.interactions[0].second == 3);
  const decid::cohort::Effect& effect = found.interactions[0].effects[0];
  CHECK(holds(effect.difference, decid::normal_distribution(0.5 / std::sqrt(1.17)) - 0.5));
  CHECK(effect.difference.interval95[0] > 0.0);
  CHECK(effect.direction > 0.99);
  CHECK(holds(effect.standardised, 0.5 / 0.41));
  CHECK(effect.simultaneous95[0] <= effect.difference.interval95[0]);
  CHECK(effect.simultaneous95[1] >= effect.difference.interval95[1]);
  // Persons' own levels cancel: the groups' difference in one session is less certain.
  CHECK(effect.difference.sd < 0.75 * found.comparisons[1].effects[0].difference.sd);
}

TEST_CASE("cohort: differences of differences between groups, sessions and conditions, each once") {
  Normals normal(10);
  std::vector<Recording> recordings;
  for (const char* group : {"a", "b"})
    for (int i = 0; i < 2; ++i)
      for (const char* session : {"1", "2"})
        for (const char* condition : {"closed", "open"})
          recordings.push_back(
              {group + std::to_string(i), session, group, condition, {}, gaussian({0.3 * normal()}, 0.3)});
  decid::cohort::Settings settings;
  settings.draws = 20;
  settings.warm_up = 10;
  const Result found = analyse(recordings, 1, settings);
  CHECK(found.cells.size() == 8);
  CHECK(found.comparisons.size() == 12);
  CHECK(found.interactions.size() == 6);
  for (const decid::cohort::Interaction& one : found.interactions) {
    const auto cell_of = [&](std::size_t comparison) { return found.cells[found.comparisons[comparison].first]; };
    const decid::cohort::Cell first = cell_of(one.first), second = cell_of(one.second);
    if (first.session != second.session) CHECK(first.session == "2");
  }
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
