// The sentences that say which parameters of groups differ, and the notes above them.
#include <limits>

#include "base/error.hpp"
#include "tests/tools/decid/groups/compared.hpp"
#include "tools/decid/results/group_results.hpp"
#include "tools/report/json/group_verdicts.hpp"

using decid::GroupTable;
using decid::Json;
using decid::Report;
using namespace decid::test;
using decid::tools::verdicts_text;

TEST_CASE("group_verdicts: the parameters whose deciding interval leaves out 0, in people's units") {
  Report report;
  decid::GroupComparison& comparison = report.groups.emplace().comparison;
  comparison.groups.resize(2);
  comparison.groups[0].name = "patients";
  comparison.groups[1].name = "controls";
  decid::GroupPair pair;
  pair.second = 1;
  pair.participants = {1, 8};
  decid::GroupEffect effect;
  effect.difference = 1.0;
  effect.adjusted_interval95 = {-1.0, 3.0};
  pair.parameters.assign(7, effect);
  effect.difference = -90.0;
  effect.adjusted_interval95 = {-160.0, -20.0};
  pair.parameters[0] = effect;
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  effect.difference = 1.0;
  effect.adjusted_interval95 = {unknown, unknown};
  pair.parameters[4] = effect;
  effect.difference = 0.021;
  effect.adjusted_interval95 = {0.005, 0.037};
  pair.parameters[6] = effect;
  comparison.pairs = {pair};
  const decid::tools::GroupVerdicts found = decid::tools::group_verdicts(report);
  REQUIRE(found.sentences.size() == 1);
  CAPTURE(found.sentences[0]);
  for (const char* fact :
       {"Kp: controls higher, 90 N m/rad [20, 160]", "delay: patients longer, 21 ms [5, 37]",
        "no difference shown in: Kd, Kp_pass, Kd_pass, theta", "no interval of: Nv (too few people)"})
    CHECK(contains(found.sentences[0], fact));
  CHECK(decid::tools::group_verdicts({}).sentences.empty());
}

TEST_CASE("group_verdicts: a difference of changes names both changes, and where they are") {
  Report report;
  decid::cohort::Result& model = report.groups.emplace().hierarchical.emplace();
  for (const char* group : {"controls", "patients"})
    for (const char* session : {"1", "2"}) {
      decid::cohort::Cell& cell = model.cells.emplace_back();
      cell.group = group;
      cell.session = session;
    }
  const auto effects = [](double nv, double delay, std::array<double, 2> of_nv) {
    std::vector<decid::cohort::Effect> all(7);
    for (decid::cohort::Effect& effect : all) effect.simultaneous95 = {-1.0, 1.0};
    all[4].difference.mean = nv;
    all[4].simultaneous95 = of_nv;
    all[6].difference.mean = delay;
    all[6].simultaneous95 = {-0.03, -0.01};
    return all;
  };
  model.comparisons = {{1, 0, 0, effects(0.012, 0.0, {-1.0, 1.0})}, {3, 2, 0, effects(-0.103, 0.02, {-1.0, 1.0})}};
  model.interactions = {{0, 1, effects(0.115, -0.02, {0.03, 0.2})}};
  std::vector<std::string> found = decid::tools::group_verdicts(report).sentences;
  REQUIRE(found.size() == 3);
  CHECK(contains(found[2], "Nv: 0.012 in controls, -0.103 in patients; difference of the changes 0.115 [0.03, 0.2]"));
  CHECK(contains(found[2], "delay: 0 ms in controls, 20 ms in patients; difference of the changes -20 ms [-30, -10]"));
  CHECK(found[2].starts_with("2 minus 1, in controls and in patients: "));
  for (decid::cohort::Cell& cell : model.cells) {
    cell.condition = cell.session == "1" ? "EO" : "EC";
    cell.session = cell.group == "controls" ? "1" : "2";
    cell.group = decid::cohort::everyone;
  }
  found = decid::tools::group_verdicts(report).sentences;
  CHECK(found[2].starts_with("EC minus EO, in session 1 and in session 2: "));
}

TEST_CASE("verdicts: chains of the hierarchical model that disagree are noted") {
  Report report;
  GroupTable table{"subject", {}};
  for (int i = 0; i < 3; ++i) {
    add(report, table, "a", "a" + std::to_string(i), recording("f", 700.0 + i));
    add(report, table, "b", "b" + std::to_string(i), recording("f", 900.0 + i));
  }
  report.groups = decid::report_groups(table, report);
  decid::cohort::Result model;
  model.max_rhat = 1.05;
  report.groups->hierarchical = model;
  CHECK(decid::tools::group_verdicts(report).notes.empty());
  report.groups->hierarchical->max_rhat = 1.06;
  const decid::tools::GroupVerdicts found = decid::tools::group_verdicts(report);
  REQUIRE(found.notes.size() == 1);
  CHECK(contains(found.notes[0], "1.06"));
  report.groups->hierarchical->max_rhat = std::numeric_limits<double>::quiet_NaN();
  CHECK(decid::tools::group_verdicts(report).notes.size() == 1);
}

TEST_CASE(
    "verdicts: notes on people, on groups of one person and on marks of exclusion; numbers are group 0 and group 1") {
  Report report;
  GroupTable table{"", {}};
  table.other_columns = {"Tester", "age"};
  const auto add_group = [&](const std::string& group, int count, double value) {
    for (int i = 0; i < count; ++i) add(report, table, group, group + std::to_string(i), recording("f", value + i));
  };
  add_group("0", 3, 700.0);
  add_group("1", 3, 900.0);
  report.groups = decid::report_groups(table, report);
  decid::tools::GroupVerdicts found = decid::tools::group_verdicts(report);
  REQUIRE(found.sentences.size() == 1);
  CHECK(contains(found.sentences[0], "group 0 and group 1: Kp: group 1 higher"));
  REQUIRE(found.notes.size() == 1);
  CHECK(contains(found.notes[0], "each recording counts as a person"));
  CHECK(contains(verdicts_text(report), found.notes[0] + "\n  group 0 and group 1"));

  report = {};
  table = {"subject", {}};
  add_group("patients", 3, 700.0);
  add_group("controls", 3, 900.0);
  add_group("patient", 1, 700.0);
  add_group("Excluded", 2, 100.0);
  const Json json = compared(report, table);
  CHECK(json["comparisons"].size() == 3);
  CHECK(json["group_comparison"]["intervals"] == 21);
  CHECK(json["group_comparison"]["too_small_groups"] == Json{"patient"});
  found = decid::tools::group_verdicts(report);
  CHECK(found.sentences.size() == 3);
  REQUIRE(found.notes.size() == 2);
  CHECK(contains(found.notes[0], "Group 'patient' has one person: a typo of 'patients'?"));
  CHECK(contains(found.notes[1], "'Excluded'"));
  CHECK(decid::tools::page_groups(report)["verdicts"]["notes"].size() == 2);

  report = {};
  table = {"subject", {}};
  table.has_groups = false;
  for (const char* session : {"1", "10", "2"})
    for (const char* person : {"a", "b"}) {
      add(report, table, "all", person, recording("f", 700.0 + *person * std::stod(session)));
      table.members.back().session = session;
    }
  report.groups = decid::report_groups(table, report);
  found = decid::tools::group_verdicts(report);
  REQUIRE(found.sentences.size() == 3);
  CHECK(found.sentences[0].starts_with("session 2 and session 1: "));
  CHECK(found.sentences[2].starts_with("session 10 and session 2: "));  // by their numbers
  CHECK(found.notes.empty());
}

TEST_CASE("verdicts: groups, sessions and conditions of any size that may be one, misspelled, are noted") {
  const auto notes_of = [](const std::vector<std::string>& labels, std::string decid::GroupMember::*column) {
    Report report;
    GroupTable table{"subject", {}};
    double value = 700.0;
    for (const std::string& label : labels)
      for (const char* person : {"a", "b", "c"}) {
        const bool is_group = column == &decid::GroupMember::group;
        add(report, table, is_group ? label : "all", is_group ? person + label : person, recording("f", value += 1.0));
        table.members.back().*column = label;
      }
    report.groups = decid::report_groups(table, report);
    return decid::tools::group_verdicts(report).notes;
  };
  for (const auto column : {&decid::GroupMember::group, &decid::GroupMember::session, &decid::GroupMember::condition}) {
    const std::vector<std::string> found = notes_of({"patients", "controls", "patient", "Kontrollen"}, column);
    REQUIRE(found.size() == 1);
    CHECK(contains(found[0], "'patient' and 'patients'"));
    CHECK(notes_of({"eyes opne", "eyes open"}, column).size() == 0);  // of four letters
    CHECK(notes_of({"eyes closed", "eyes clsed"}, column).size() == 1);
    for (const auto& other : {std::vector<std::string>{"male", "female"},
                              {"test", "retest"},
                              {"DBS on", "DBS off"},
                              {"EO1", "EC1"},
                              {"left leg", "right leg"},
                              {"visit 1", "visit 2"},
                              {"day 10", "day 100"},
                              {"pre", "post"},
                              {"fast", "last"}}) {
      CAPTURE(other[0]);
      CHECK(notes_of(other, column).empty());
    }
  }
}

TEST_CASE("verdicts: notes on conditions that differ between groups, on sessions of one person, on unclear dates") {
  Report report;
  GroupTable table{"subject", {}};
  double value = 700.0;
  const auto add_one = [&](const std::string& group, const std::string& person, const std::string& session,
                           const std::string& condition) {
    add(report, table, group, person, recording("f", value += 1.0));
    table.members.back().sheet_session = session;
    table.members.back().sheet_condition = condition;
  };
  const auto notes = [&] {
    report.groups = decid::report_groups(table, report);
    return decid::tools::group_verdicts(report).notes;
  };
  for (const char* person : {"a", "b"})
    for (const char* condition : {"EO", "EC"}) add_one("patients", person, "", condition);
  for (const char* person : {"c", "d"}) add_one("controls", person, "", "EO");
  std::vector<std::string> found = notes();
  REQUIRE(found.size() == 1);
  CHECK(contains(found[0], "different conditions (recordings of controls: 2 of EO; patients: 2 of EC, 2 of EO)"));
  CHECK(decid::tools::groups_json(report)["group_comparison"]["notes"] == Json(found));
  CHECK(decid::tools::page_groups(report)["verdicts"]["notes"] == Json(found));
  report.sheet.emplace();
  for (const char* person : {"c", "d"}) add_one("controls", person, "", "EC");
  CHECK(notes().empty());
  for (const char* person : {"c", "d"}) add_one("controls", person, "", "EC");
  CHECK(notes().empty());  // a share of 2/3 instead of 1/2
  for (int i = 0; i < 6; ++i) add_one("controls", "c", "", "EC");
  found = notes();
  REQUIRE(found.size() == 1);
  for (decid::GroupMember& member : table.members) {
    member.session = "1";  // is compared
    if (member.group == "controls") member.sheet_session = "2";
  }
  found = notes();
  REQUIRE(found.size() == 1);
  CHECK(contains(found[0], "within session,condition)"));
  for (decid::GroupMember& member : table.members) member.condition = member.sheet_condition;
  CHECK(notes().empty());

  // The sessions of one person have one person each.
  report = {};
  table = {"subject", {}};
  table.has_groups = false;
  for (const char* session : {"1", "2", "3"}) {
    add_one("all", "a", session, "");
    table.members.back().session = session;
  }
  CHECK(notes().empty());

  // Each person has dates of its own: one note for all, instead of one per date.
  report = {};
  table = {"subject", {}};
  table.has_groups = false;
  for (const char* person : {"a", "b"})
    for (const char* session : {"1", "2"}) {
      add_one("all", person, person + std::string(session), "");
      table.members.back().session = table.members.back().sheet_session;
    }
  found = notes();
  REQUIRE(found.size() == 1);
  CHECK(contains(found[0], "Most sessions have one person alone (a1, a2, b1, b2)"));
  // A session without a recording that can be used has a note of its own.
  const auto add_unusable = [&](const std::string& person, const std::string& session) {
    add_one("all", person, session, "");
    table.members.back().session = session;
    report.recordings.back().error = decid::Error(decid::Code::file_missing, "f", "is missing", "name another");
  };
  add_unusable("c", "c1");
  found = notes();
  REQUIRE(found.size() == 2);
  CHECK(contains(found[1], "No recording of group 'c1' can be used"));
  table.members.pop_back();
  report.recordings.pop_back();
  const auto with_dates = [&](const std::string& first, const std::string& second) {
    for (decid::GroupMember& member : table.members)
      member.session = member.sheet_session.ends_with("1") ? first : second;
    return notes();
  };
  CHECK(with_dates("10.01.2023", "09.02.2023").empty());
  CHECK(report.groups->comparison.groups[0].name == "10.01.2023");
  CHECK(with_dates("13/01/2023", "09/02/2023").empty());
  found = with_dates("01/10/2023", "09/02/2023");
  REQUIRE(found.size() == 1);
  CHECK(contains(found[0], "Session 01/10/2023 is ordered as day, month and year"));
}
