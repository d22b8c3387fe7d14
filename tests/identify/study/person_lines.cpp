// The lines of a sheet that paths of recordings fit: which person, which session, and what is unclear; persons whose
// lines contradict each other.
#include "identify/study/detail/person_lines.hpp"

#include <doctest/doctest.h>

#include <algorithm>

#include "identify/study/recording_plan.hpp"
#include "tests/helpers.hpp"
#include "tests/identify/study/sheet_files.hpp"

using namespace decid;
using namespace decid::test;

namespace {

using Naming = PathKey::Naming;

Naming participant(const std::string& path, const std::string& name) {
  return PathKey(path).naming_of_participant(name);
}

/// The participant and the session of each file's recording, in the order of the files; the code of an error.
std::vector<std::string> people(const std::string& sheet, const std::vector<std::string>& files, Choice choice) {
  const TemporaryFolder folder;
  std::vector<std::string> found(files.size(), "none");
  for (const PlannedRecording& one : plan_of_text(folder, sheet, files, choice).recordings)
    for (std::size_t i = 0; i < files.size(); ++i)
      if (one.source.name() == (folder / files[i]).string())
        found[i] = one.error ? name(one.error->code()) : one.entry.participant + one.entry.session;
  return found;
}

/// expected: "none" for a recording without a line, which is an error only if the call names it.
void check_people(const std::string& sheet, const std::vector<std::string>& files, std::vector<std::string> expected) {
  CAPTURE(sheet);
  CHECK(people(sheet, files, Choice::by_sheet) == expected);
  std::ranges::replace(expected, std::string("none"), std::string("value_missing"));
  CHECK(people(sheet, files, Choice::by_call) == expected);
}

}  // namespace

TEST_CASE("path_match: how clearly a path names a participant") {
  CHECK(participant("data/sub-01/ses-2/t.csv", "sub-01") == Naming::prefixed);
  CHECK(participant("data/sub-01/ses-2/t.csv", "01") == Naming::prefixed);
  CHECK(participant("sub-01_ses-2_t.csv", "SUB-01") == Naming::prefixed);
  CHECK(PathKey("data/sub-01/ses-2/t.csv").naming_of_session("2", "01") == Naming::prefixed);
  // People and sessions may have the same labels: a part that names the person names no session.
  CHECK(PathKey("E/1/2.csv").naming_of_session("1", "1") == Naming::none);
  CHECK(PathKey("E/1/2.csv").naming_of_session("2", "1") == Naming::within);
  CHECK(PathKey("E/1/1.csv").naming_of_session("1", "1") == Naming::within);
  CHECK(PathKey("E/1/1/t.csv").naming_of_session("1", "1") == Naming::folder);
  CHECK(PathKey("E/sub-1/1/t.csv").naming_of_session("1", "1") == Naming::folder);
  CHECK(PathKey("E/1/ses-1_t.csv").naming_of_session("1", "1") == Naming::prefixed);
  CHECK(participant("data/sub-010/t.csv", "sub-01") == Naming::none);
  CHECK(participant("sub-01-b/t.csv", "sub-01") == Naming::within);
  CHECK(participant("sub-01-b/t.csv", "sub-01-b") == Naming::prefixed);
  CHECK(participant("1/trial.csv", "1") == Naming::folder);
  CHECK(participant("P1/P1_closed.csv", "p1") == Naming::folder);
  CHECK(participant("P1_closed.csv", "p1") == Naming::within);
  CHECK(participant("2/1.csv", "1") == Naming::within);
  CHECK(participant("P10_closed.csv", "P1") == Naming::none);
  CHECK(participant("trial_1.csv", "1") == Naming::none);
  CHECK(participant("t.csv", "") == Naming::none);
}

TEST_CASE("path_match: the sessions of a path in BIDS' names") {
  using Labels = std::vector<std::string>;
  const auto labels = [](const std::string& path) { return PathKey(path).session_labels(); };
  CHECK(labels("sub-01/ses-1/motion/sub-01_ses-1_task-sway_motion.tsv") == Labels{"1"});
  CHECK(labels("sub-01/SES-Pre/t.csv") == Labels{"Pre"});
  CHECK(labels("Sub-01/ses-pre/sub-01_ses-Pre_t.csv") == Labels{"pre"});
  CHECK(labels("sub-01_ses-2.csv") == Labels{"2"});
  CHECK(labels("sub-01_ses-2.csv#3") == Labels{"2"});
  CHECK(labels("ses-pilot/sub-01/ses-3/t.csv") == Labels{"3"});  // a folder above the people is no visit
  CHECK(labels("sub-01/ses-1/sub-01_ses-2_t.csv") == Labels{"1", "2"});
  for (const char* path : {"sub-01/t.csv", "courses-1/noses-2_t.csv", "sub-1/ses-/t.csv", "ses-1/t.csv", ""})
    CHECK(labels(path).empty());
}

TEST_CASE("lines of people: a folder and sub- come before a file's name; two people equally clear are an error") {
  check_people("participant_id\tgroup\n1\tx\n2\ty\n", {"1/1.csv", "1/2.csv", "2/1.csv", "2/2.csv"},
               {"1", "1", "2", "2"});
  check_people("participant_id\tgroup\nEC\tx\nAB\ty\n", {"AB_EC.csv", "AB/EC.csv", "EC_1.csv", "EC/sub-AB_1.csv"},
               {"value_invalid", "AB", "EC", "AB"});
  check_people("participant_id\tgroup\nS01\tx\nS01-B\ty\n", {"S01-B/t.csv", "S01/t.csv", "S01-B_t.csv"},
               {"S01-B", "S01", "value_invalid"});
  // Two lines of one person, however it is spelled, are no contradiction.
  check_people("participant_id\tsession\nP1\t1\np1\t2\nP1\tn/a\n", {"p1/ses-1/t.csv", "P1/ses-2/t.csv", "P1/t.csv"},
               {"P11", "p12", "P1"});
  // The folder is of AB, who has a line of another session only.
  check_people("participant_id\tsession\nAB\t1\nEC\tn/a\n", {"AB/ses-1/t.csv", "AB/ses-2/EC.csv", "EC/t.csv"},
               {"AB1", "none", "EC"});
  check_people("participant_id\tsession\nP\t1\nP\t2\n", {"P/1/2.csv", "P/2/1.csv", "P/1-2.csv", "P/ses-1_ses-2.csv"},
               {"P1", "P2", "none", "value_invalid"});
}

TEST_CASE("lines of people: an unclear recording names both lines, and neither person lacks a recording") {
  const TemporaryFolder folder;
  const RecordingPlan plan = plan_of_text(folder, "ID\tgroup\nAB\tx\nEC\ty\n", {"AB_EC.csv"}, Choice::by_sheet);
  REQUIRE(plan.recordings.size() == 1);
  REQUIRE(plan.recordings[0].error);
  check_error([&] { throw *plan.recordings[0].error; }, Code::value_invalid, "line 2 (AB) and line 3 (EC)");
  CHECK(plan.recordings[0].entry.participant.empty());
  CHECK(plan.recordings[0].entry.group.empty());
}

TEST_CASE("lines of people: a person's line fills lines of recordings in any spelling of participant and session") {
  const TemporaryFolder folder;
  const std::string sheet =
      "participant_id\tsession\tfile\tgroup\tweight\theight\nP1\tPre\tn/a\tx\t70\t175\np1\tpre\ta.csv\tn/a\tn/a\tn/a\n"
      "P1\tpost\tb.csv\tn/a\tn/a\tn/a\n";
  for (const Choice choice : {Choice::by_sheet, Choice::by_call}) {
    const RecordingPlan plan = plan_of_text(folder, sheet, {"a.csv", "b.csv"}, choice);
    REQUIRE(plan.recordings.size() == 2);  // P1 has recordings, so its line is no error
    CHECK(plan.notes.empty());
    CHECK(plan.recordings[0].entry.group == "x");
    CHECK(plan.recordings[0].mass_kg == 70.0);
    CHECK(plan.recordings[0].warnings.empty());
    CHECK(plan.recordings[1].entry.group.empty());  // of another session, whose body counts
    CHECK(plan.recordings[1].mass_kg == 70.0);
    REQUIRE(plan.recordings[1].warnings.size() == 1);
    CHECK(plan.recordings[1].warnings[0].code == "body_of_other_line");
    CHECK(contains(plan.recordings[1].warnings[0].text, "70 kg of line 2, session Pre"));
  }
}

TEST_CASE("make_plan: a person in two groups is refused with both lines, whatever the session") {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    const StudySheet sheet = read_sheet(write_text(folder / "g.csv", "participant_id,session,group,file\n" + text));
    return make_plan(sheet, {}, Choice::by_sheet, {}).sheet->lines.size();
  };
  for (const char* sessions :
       {"P1,1,patients,a.csv\nP2,1,controls,b.csv\nP1,1,controls,c.csv\n",
        "P1,1,patients,a.csv\nP2,1,controls,b.csv\np1,2,controls,c.csv\n", "P1,,patients,\n\nP1,2,controls,c.csv\n"}) {
    CAPTURE(sessions);
    check_error([&] { read(sessions); }, Code::value_invalid, "g.csv, lines 2 and 4");
    check_error([&] { read(sessions); }, Code::value_invalid, "\"patients\" and \"controls\"");
  }
  CHECK(read("P1,1,patients,a.csv\np1,2,Patients,b.csv\nP1,3,n/a,c.csv\n,1,x,d.csv\n,1,y,e.csv\n") == 5);
}

TEST_CASE("make_plan: two spellings of a person are refused with both lines") {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& one, const std::string& other, Choice choice = Choice::by_sheet) {
    const StudySheet sheet = read_sheet(
        write_text(folder / "g.csv", "participant_id;file\n" + one + ";a.csv\nP7;b.csv\n" + other + ";c.csv\n"));
    return make_plan(sheet, {}, choice, {}).sheet->lines.size();
  };
  using Pairs = std::vector<std::pair<std::string, std::string>>;
  for (const auto& both : Pairs{{"01", "1"},
                                {"4.0", "4"},
                                {"4", "4,0"},
                                {"S 1", "S1"},
                                {"s-2", "S2"},
                                {"S_2", "S 2"},
                                {"sub-S3", "S3"},
                                {"sub-01", "01"},
                                {"P01", "p1"},
                                {"A-01", "A1"},
                                {"1-01", "1 1"}}) {
    CAPTURE(both.first);
    for (const Choice choice : {Choice::by_sheet, Choice::by_call, Choice::for_groups})
      check_error([&] { read(both.first, both.second, choice); }, Code::value_invalid, "g.csv, lines 2 and 4");
  }
  for (const auto& both : Pairs{{"s1", "S1"},
                                {"1", "10"},
                                {"0", "10"},
                                {"1-11", "11-1"},
                                {"1.1", "1.10"},
                                {"1.01", "1.1"},
                                {"100", "1"},
                                {"S1", "T1"},
                                {"subs", "sub-b"}}) {
    CAPTURE(both.first);
    CHECK(read(both.first, both.second) == 3);
  }
}
