// The hierarchical model of people in several sessions: changes, which session is later, and differences of changes.
#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/math/math.hpp"
#include "identify/cohort/cohort.hpp"
#include "tests/identify/cohort/made_up.hpp"

using decid::cohort::Quantity;
using decid::cohort::Recording;
using decid::cohort::Result;
using namespace decid::test;

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
  CHECK(excludes_zero(found.changes[0].difference[0]));
  CHECK_FALSE(found.changes[0].changed(0));  // without the interval of the own recordings
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
