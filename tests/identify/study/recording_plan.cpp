// The recordings of a study's sheet: found by their paths, each with its line, and what is unclear or missing.
#include "identify/study/recording_plan.hpp"

#include <doctest/doctest.h>

#include <optional>

#include "identify/study/find_recordings.hpp"
#include "identify/study/study_results.hpp"
#include "sim/segments.hpp"
#include "tests/helpers.hpp"
#include "tests/identify/study/sheet_files.hpp"

using namespace decid;
using namespace decid::test;

TEST_CASE("plan_of a sheet of files: the call's recordings, their own options, those without a line or a file") {
  const TemporaryFolder folder;
  const RecordingPlan plan = plan_of_text(folder,
                                          "participant_id\tfile\theight\tweight\tinvert\tprotocol\n"
                                          "A\ta/t.csv\t175\t70\tsway\tn/a\nB\tB/T.csv\t1.75\t70\tn/a\tshort\n"
                                          "C\tc/t.csv\tn/a\tn/a\tn/a\tn/a\nD\tgone.csv\t160\t60\tn/a\tn/a\n"
                                          "E\te.csv\t160\tn/a\tn/a\tn/a\n",
                                          {"a/t.csv", "b/t.csv", "x.csv", "c/t.csv", "e.csv"}, Choice::by_call);
  REQUIRE(plan.recordings.size() == 6);
  const PlannedRecording& a = plan.recordings[0];
  CHECK(a.entry.participant == "A");
  CHECK(a.reading.recording.invert_sway);
  CHECK(a.reading.recording.body_height_m == 1.75);
  CHECK(a.reading.body == sim::body_of_participant({.mass_kg = 70.0, .height_m = 1.75}));
  const PlannedRecording& b = plan.recordings[1];
  CHECK(b.entry.participant == "B");
  CHECK_FALSE(b.reading.recording.invert_sway);
  CHECK(b.setting != a.setting);  // another protocol
  CHECK(plan.settings[b.setting].body == plan.settings[a.setting].body);
  CHECK(plan.settings[b.setting].protocol == "short");
  check_has(plan.recordings[2].error, Code::value_missing, "x.csv");
  CHECK_FALSE(plan.recordings[3].error);
  CHECK_FALSE(plan.recordings[3].reading.body);
  check_has(plan.recordings[4].error, Code::value_missing, "no weight");
  CHECK(plan.recordings[5].entry.participant == "D");
  check_has(plan.recordings[5].error, Code::file_missing, "gone.csv");
  CHECK(plan.notes.empty());
}

TEST_CASE("plan_of a sheet of people: their recordings near the sheet, sessions, people without one") {
  const TemporaryFolder folder;
  const RecordingPlan plan = plan_of_text(
      folder,
      "participant_id\tsession\tcondition\tfile\n01\tn/a\tx\tn/a\n"
      "01\t2\ty\tn/a\nJ\u00FCrgen\tn/a\tn/a\tn/a\nQ\tn/a\tz\tn/a\n"
      "01\tn/a\tw\tsub-01/extra.csv\n",
      {"sub-01/ses-1/t.csv", "sub-01/ses-2/t.csv", "sub-01/extra.csv", "sub-02/t.csv", "ju\u0308rgen 1.csv"},
      Choice::by_sheet);
  std::vector<std::pair<std::string, std::string>> found;  // file and condition
  for (const PlannedRecording& recording : plan.recordings)
    found.emplace_back(recording.source.file.lexically_relative(folder.path()).string(), recording.entry.condition);
  REQUIRE(found.size() == 5);
  CHECK(found[0] == std::pair<std::string, std::string>("sub-01/ses-1/t.csv", "x"));
  CHECK(found[1] == std::pair<std::string, std::string>("sub-01/ses-2/t.csv", "y"));
  CHECK(found[2].first == "ju\u0308rgen 1.csv");
  CHECK(plan.recordings[3].source.name() == "Q");
  check_has(plan.recordings[3].error, Code::file_missing, "line 5");
  CHECK(found[4] == std::pair<std::string, std::string>("sub-01/extra.csv", "w"));
}

TEST_CASE("plan_of: sessions are those of BIDS' paths, unless a line has one") {
  const TemporaryFolder folder;
  const std::string name = "motion/sub-01_task-sway_motion.tsv";
  const std::vector<std::string> files{"sub-01/ses-1/" + name, "sub-01/ses-2/" + name, "sub-02/" + name};
  for (const Choice choice : {Choice::by_sheet, Choice::by_call}) {
    const std::string sheet = "participant_id\tage\theight\tweight\nsub-01\t33\t175\t70\nsub-02\t40\t165\t60\n";
    const RecordingPlan plan = plan_of_text(folder, sheet, files, choice);
    REQUIRE(plan.recordings.size() == 3);
    CHECK(plan.recordings[0].entry.session == "1");
    CHECK(plan.recordings[1].entry.session == "2");
    CHECK(plan.recordings[2].entry.session.empty());
    for (const PlannedRecording& one : plan.recordings) CHECK(one.warnings.empty());
  }
  // A missing body comes from the line of the same session, also where the path tells it.
  const std::vector<std::string> visits{"sub-01/ses-1/t.csv", "sub-01/ses-2/t.csv", "sub-01/ses-1/u.csv"};
  const RecordingPlan weights =
      plan_of_text(folder,
                   "file\tparticipant_id\theight\tweight\n" + visits[0] + "\tsub-01\t175\t80\n" + visits[1] +
                       "\tsub-01\t175\t95\n" + visits[2] + "\tsub-01\t175\tn/a\n",
                   visits, Choice::by_sheet);
  REQUIRE(weights.recordings.size() == 3);
  CHECK(weights.recordings[2].entry.session == "1");
  CHECK(weights.recordings[2].mass_kg == 80.0);
  // Two sessions in a path.
  const RecordingPlan unclear =
      plan_of_text(folder, "participant_id\nsub-01\n", {"sub-01/ses-1/a_ses-2_t.csv"}, Choice::by_call);
  REQUIRE(unclear.recordings.size() == 1);
  REQUIRE(unclear.recordings[0].error);
  CHECK(unclear.recordings[0].error->code() == Code::value_invalid);
  const RecordingPlan stated = plan_of_text(folder, "participant_id\tsession\nsub-01\tn/a\nsub-02\tlate\n",
                                            {files[0], "sub-02/ses-late/t.csv"}, Choice::by_call);
  CHECK(stated.recordings[0].entry.session.empty());
  CHECK(stated.recordings[1].entry.session == "late");
}

TEST_CASE("plan_of: a person's line fills the lines of recordings; what is not clear is an error") {
  const TemporaryFolder folder;
  const std::vector<std::string> files{"a/t.csv", "b/t.csv", "A_open.csv"};
  const RecordingPlan filled = plan_of_text(folder,
                                            "participant_id\tfile\tage\theight\tweight\tbegin\n"
                                            "A\tn/a\t71\t175\t70\t3\nA\tA_open.csv\tn/a\tn/a\tn/a\t5\n",
                                            files, Choice::by_sheet);
  REQUIRE(filled.recordings.size() == 2);  // a folder called like the person is that person's
  CHECK(filled.recordings[0].source.file == folder / "a/t.csv");
  CHECK(filled.recordings[1].entry.cells == std::vector<std::string>{"71"});
  CHECK(filled.recordings[1].mass_kg == 70.0);
  CHECK(filled.recordings[1].reading.trial.start_s == 5.0);
  CHECK(filled.recordings[0].reading.trial.start_s == 3.0);

  const RecordingPlan nobody = plan_of_text(folder, "participant_id\tgroup\nn/a\tx\n", files, Choice::by_sheet);
  REQUIRE(nobody.recordings.size() == 1);
  check_has(nobody.recordings[0].error, Code::value_missing, "line 2");
  const RecordingPlan unclear = plan_of_text(folder, "file\nt\nA_open.mat\n", files, Choice::by_sheet);
  check_has(unclear.recordings[0].error, Code::value_invalid, "line 2");
  CHECK(unclear.recordings[1].source.file == folder / "A_open.csv");
  const RecordingPlan twice =
      plan_of_text(folder, "file\tgroup\na/t.csv\tx\nA/T.csv\ty\nt.csv\tz\n", files, Choice::by_call);
  CHECK(twice.recordings[0].entry.group == "x");  // the exact one
  CHECK(twice.recordings[1].entry.group == "z");
  const RecordingPlan two = plan_of_text(folder, "file\tgroup\na/t.csv\tx\na/t.csv\ty\n", files, Choice::by_call);
  check_has(two.recordings[0].error, Code::value_invalid, "line 3");
  const RecordingPlan unused =
      plan_of_text(folder, "participant_id\tfile\nA\ta/t.csv\nZ\tn/a\n", {"a/t.csv"}, Choice::by_call);
  CHECK(unused.recordings.size() == 1);
  CHECK(unused.notes.size() == 1);
  const RecordingPlan part = plan_of_text(folder, "file\nt.csv\nA_OPEN.csv\ngone.csv\n", {"a/t.csv"}, Choice::by_call);
  REQUIRE(part.recordings.size() == 2);  // A_open.csv exists, so the call left it out
  CHECK(part.notes.size() == 1);
  check_has(part.recordings[1].error, Code::file_missing, "gone.csv");
}

TEST_CASE("plan_of: the sheet among its recordings is none of them, although its name is a person's") {
  const TemporaryFolder folder;
  const std::filesystem::path path = write_text(folder / "A.csv", "participant_id,group\nA,x\nB,y\n");
  std::vector<RecordingSource> all = sources(folder, {"A_1.csv", "B.csv"});
  all.emplace_back(folder.path() / "." / "A.csv");
  for (const Choice choice : {Choice::by_sheet, Choice::by_call}) {
    const RecordingPlan plan = make_plan(read_sheet(path), all, choice, {});
    REQUIRE(plan.recordings.size() == 2);
    CHECK(plan.recordings[0].source.file == folder / "A_1.csv");
    CHECK(plan.recordings[1].entry.participant == "B");
  }
}

TEST_CASE("plan_of: a recording named twice, and cells beyond the names, are errors of their lines") {
  const TemporaryFolder folder;
  const RecordingPlan plan = plan_of_text(
      folder,
      "ID\tfile\tweight\theight\na\ta.csv\t70\t175\na\ta.csv\t70\t175\nb\tb.csv\t70\t175\t5\nc\tc.csv\t70\t1.75\t\n",
      {"a.csv", "b.csv", "c.csv"}, Choice::by_sheet);
  REQUIRE(plan.recordings.size() == 4);
  CHECK(plan.recordings[0].entry.participant == "a");
  CHECK_FALSE(plan.recordings[0].error);
  check_has(plan.recordings[1].error, Code::value_invalid, "line 2");
  check_has(plan.recordings[2].error, Code::value_invalid, "5 cells");
  CHECK_FALSE(plan.recordings[3].error);
  // Other options of reading make it another recording.
  const RecordingPlan columns =
      plan_of_text(folder, "file\tcolumn\na.csv\tone\na.csv\ttwo\n", {"a.csv"}, Choice::by_sheet);
  REQUIRE(columns.recordings.size() == 2);
  CHECK_FALSE(columns.recordings[1].error);
}

TEST_CASE("plan_of: two bodies and two ages of a person in one session are warnings of both recordings") {
  const TemporaryFolder folder;
  const std::vector<std::string> files{"a.csv", "b.csv", "c.csv", "d.csv"};
  const auto planned = [&](const std::string& sheet) {
    return plan_of_text(folder, sheet, files, Choice::by_sheet).recordings;
  };
  const auto codes = [](const PlannedRecording& one) {
    std::vector<std::string> all;
    for (const Warning& warning : one.warnings)
      if (warning.severity == Severity::caution) all.push_back(warning.code);
    return all;
  };
  using Codes = std::vector<std::string>;
  const auto in_sessions = planned(
      "ID\tsession\tfile\tweight\theight\tage\n"
      "P1\t1\ta.csv\t70\t175\t60\n"
      "p1\t1\tb.csv\t80,5\t1.75\t61\n"  // contradicts a.csv
      "P1\t2\tc.csv\t75\t1.75\t61\n"    // a year later
      "P2\t1\td.csv\t90\t1.80\t60\n");
  REQUIRE(in_sessions.size() == 4);
  CHECK(codes(in_sessions[0]) == Codes{"two_bodies", "two_ages"});
  CHECK(codes(in_sessions[1]) == Codes{"two_bodies", "two_ages"});
  CHECK(codes(in_sessions[2]).empty());
  CHECK(codes(in_sessions[3]).empty());
  for (const char* fact : {"P1", "session 1", "70 kg", "80.5 kg", "b.csv"})
    CHECK(contains(in_sessions[0].warnings[0].text, fact));
  for (const char* fact : {"60 here", "61 for"}) CHECK(contains(in_sessions[0].warnings[1].text, fact));
  CHECK(contains(in_sessions[1].warnings[0].text, "a.csv"));

  // Without sessions the values must agree; units and rounding do not count. A line without a body has that of the line
  // above, and contradicts nothing.
  const auto without = planned(
      "ID\tfile\tweight\theight\tAge (years)\nP1\ta.csv\t70\t175\t60\nP1\tb.csv\t70,0\t1.75\t60.0\n"
      "P1\tc.csv\tn/a\tn/a\tn/a\nP1\td.csv\t70\t1.74\tn/a\n");
  CHECK(codes(without[0]) == Codes{"two_bodies"});
  CHECK(codes(without[1]) == Codes{"two_bodies"});
  CHECK(codes(without[2]).empty());
  REQUIRE(without[2].warnings.size() == 1);
  CHECK(contains(without[2].warnings[0].text, "70 kg of line 3 and 1.75 m of line 3"));
  CHECK(without[2].is_body_of_other_line);
  CHECK_FALSE(without[1].is_body_of_other_line);
  CHECK(codes(without[3]) == Codes{"two_bodies"});

  // A person's line fills what a recording's line lacks. A marker has one height in a session, another one its own.
  const auto filled = planned(
      "ID\tfile\tweight\theight\tcolumn\tcom_height\tAlter\nP1\tn/a\t70\t175\tn/a\tn/a\t50\n"
      "P1\ta.csv\tn/a\tn/a\tCOM\t0.95\t51\nP1\tb.csv\tn/a\tn/a\tcom\t0.9\tn/a\n"
      "P1\tc.csv\tn/a\tn/a\tsacrum\t0.8\tn/a\n");
  REQUIRE(filled.size() == 3);
  CHECK(codes(filled[0]) == Codes{"two_bodies", "two_ages"});
  CHECK(codes(filled[1]) == Codes{"two_bodies", "two_ages"});
  CHECK(codes(filled[2]) == Codes{"two_ages"});
  CHECK(contains(filled[1].warnings[0].text, "0.95 m"));
}

TEST_CASE("plan_of: a body mass index that contradicts weight and height is a warning; a rounded one is not") {
  const TemporaryFolder folder;
  const auto text_of = [&](const std::string& name, const std::string& cells) {
    const std::string sheet = "ID\tfile\tweight\theight\t" + name + "\nP1\ta.csv\t" + cells + "\n";
    const RecordingPlan plan = plan_of_text(folder, sheet, {"a.csv"}, Choice::by_sheet);
    CHECK_FALSE(plan.recordings.at(0).error);
    std::string text;
    for (const Warning& warning : plan.recordings[0].warnings) {
      CHECK(warning.code == "other_bmi");
      CHECK(warning.severity == Severity::caution);
      text += warning.text;
    }
    return text;
  };
  const std::string found = text_of("BMI", "120\t1.75\t24");
  for (const char* fact : {"24 kg/m2", "120 kg", "1.75 m", "39.2 kg/m2"}) CHECK(contains(found, fact));
  for (const char* name : {"bmi", "Body mass index (kg/m2)", "BMI [kg/m\u00B2]", "IMC", "bmi_kg_m2"})
    CHECK_FALSE(text_of(name, "70\t175\t29,1").empty());
  // By 22.86 kg/m2: rounded, of heights and weights that were rounded (1.749 m as 1.7 m), of no unit, none.
  for (const char* index : {"22.9", "23", "22,86", "24.2", "20.0", "26.2", "n/a", "2", "999", "overweight"}) {
    CAPTURE(index);
    CHECK(text_of("BMI", std::string("70\t175\t") + index).empty());
  }
  for (const char* name : {"bmi_z", "BMI percentile", "BMI class"}) CHECK(text_of(name, "70\t175\t50").empty());
  // A body that is partly of another line contradicts nothing.
  const RecordingPlan plan = plan_of_text(folder,
                                          "ID\tsession\tfile\tweight\theight\tBMI\nP1\t1\ta.csv\t70\t175\t22.9\n"
                                          "P1\t2\tb.csv\tn/a\t175\t30\n",
                                          {"a.csv", "b.csv"}, Choice::by_sheet);
  CHECK(plan.recordings.at(1).warnings.at(0).code == "body_of_other_line");
  CHECK(plan.recordings[1].warnings.size() == 1);
}

TEST_CASE("set_planned: a result has the sheet's warnings once, before its other cautions") {
  PlannedRecording planned{std::filesystem::path("a.csv"), {}};
  add_caution(planned.warnings, "two_ages", "the sheet gives A two ages");
  RecordingResult result;
  result.warnings = {{Severity::caution, "spikes", "some"}, {Severity::info, "preamble", "one line"}};
  for (int i = 0; i < 2; ++i) {
    set_planned(result, planned);
    REQUIRE(result.warnings.size() == 3);
    CHECK(result.warnings[0].code == "two_ages");
    CHECK(result.warnings[1].code == "spikes");
  }
  CHECK(result.trust() == Trust::caution);
}

TEST_CASE("recordings_below: files that may be recordings, by name, not what describes them") {
  const TemporaryFolder folder;
  sources(folder, {"b/t.CSV", "a.mat", "b/.hidden.csv", ".git/x.csv", "participants.tsv", "b/sub-1_channels.tsv",
                   "README.txt", "report.pdf", "c.trc", "d.lvm", "~$e.xlsx"});
  std::vector<std::string> found;
  for (const std::filesystem::path& path : recordings_below(folder.path()))
    found.push_back(path.lexically_relative(folder.path()).string());
  CHECK(found == std::vector<std::string>{"a.mat", "b/t.CSV", "c.trc", "d.lvm"});
  CHECK(recordings_below(folder / "none").empty());
}

TEST_CASE("plan_of: a line without a body has that of the person's other lines, and a note; others the call's") {
  const TemporaryFolder folder;
  const std::filesystem::path path =
      write_text(folder / "s.csv",
                 "ID,session,file,height,weight\nA,1,a.csv,175,60\nA,2,b.csv,,\na,1,c.csv,n/a,\nA,2,d.csv,,65\n"
                 "B,,e.csv,,\nC,,f.csv,16,\nC,,g.csv,160,50\n");
  ReadOptions reading;
  reading.body = sim::body_of_participant({.mass_kg = 90.0, .height_m = 1.9});
  const std::vector<PlannedRecording> all =
      make_plan(read_sheet(path), sources(folder, {"a.csv", "b.csv", "c.csv", "d.csv", "e.csv", "f.csv", "g.csv"}),
                Choice::by_sheet, reading)
          .recordings;
  REQUIRE(all.size() == 7);
  CHECK(all[0].warnings.empty());
  const auto check_filled = [&](std::size_t i, double mass_kg, const std::string& fact) {
    CHECK(all[i].mass_kg == mass_kg);
    CHECK(all[i].height_m == 1.75);
    CHECK_FALSE(all[i].error);
    CHECK(all[i].reading.body == sim::body_of_participant({.mass_kg = mass_kg, .height_m = 1.75}));
    CHECK(all[i].reading.recording.body_height_m == 1.75);
    REQUIRE(all[i].warnings.size() == 1);
    CHECK(all[i].warnings[0].code == "body_of_other_line");
    CHECK(all[i].warnings[0].severity == Severity::info);
    CHECK(contains(all[i].warnings[0].text, fact));
  };
  check_filled(1, 65.0, "line 3 of the sheet has no weight and no height; decid takes 65 kg of line 5 and 1.75 m of");
  check_filled(2, 60.0, "60 kg of line 2 and 1.75 m of line 2, of the same person");
  check_filled(3, 65.0, "line 5 of the sheet has no height; decid takes 1.75 m of line 2, session 1, of");
  CHECK(all[4].reading.body == reading.body);
  CHECK(all[4].warnings.empty());
  check_has(all[5].error, Code::value_invalid, "'16'");
  CHECK_FALSE(all[6].error);
}

TEST_CASE("plan: a line with a folder is surer than a bare name, whatever its letter case and ending") {
  const TemporaryFolder folder;
  const RecordingPlan plan = plan_of_text(folder, "participant_id\tfile\nP\topen.csv\nQ\tb10/open.csv\nR\tC/open\n",
                                          {"A/open.csv", "B10/open.csv", "c/open.csv"}, Choice::by_call);
  REQUIRE(plan.recordings.size() == 3);
  CHECK(plan.recordings[0].entry.participant == "P");
  CHECK(plan.recordings[1].entry.participant == "Q");
  CHECK(plan.recordings[2].entry.participant == "R");
  // A line that another one outdoes everywhere is of no recording.
  const RecordingPlan outdone = plan_of_text(folder, "participant_id\tfile\nP\topen.csv\nQ\tb10/open.csv\n",
                                             {"B10/open.csv"}, Choice::for_groups);
  CHECK(outdone.unused == std::vector<std::size_t>{0});
}

TEST_CASE("plan: a recording of a session that its person's lines lack says which ones they have") {
  const TemporaryFolder folder;
  const RecordingPlan plan =
      plan_of_text(folder, "participant_id\tsession\n1\tpre\n1\tpost\n2\tpre\n",
                   {"sub-1/ses-pre/t.csv", "sub-1/ses-1/t.csv", "sub-3/ses-pre/t.csv"}, Choice::by_call);
  REQUIRE(plan.recordings.size() >= 3);
  CHECK_FALSE(plan.recordings[0].error);
  check_has(plan.recordings[1].error, Code::value_missing, "1 has sessions pre and post");
  check_has(plan.recordings[2].error, Code::value_missing, "has no line in");
}

TEST_CASE("plan: parts of a file that a sheet names have names of their own, and each counts") {
  const TemporaryFolder folder;
  const RecordingPlan plan = plan_of_text(folder,
                                          "participant_id\tsession\tfile\tsection\tcolumn\tunit\n"
                                          "A\t1\tbook.xlsx\tTrial 1\tsway\tdeg\nA\t2\tbook.xlsx\tTrial 2\tsway\tdeg\n"
                                          "B\t1\tsides.csv\tn/a\tleft\tdeg\nB\t2\tsides.csv\tn/a\tright\tdeg\n"
                                          "C\t1\tone.csv\tn/a\tsway\tdeg\n",
                                          {"book.xlsx", "sides.csv", "one.csv"}, Choice::by_sheet);
  REQUIRE(plan.recordings.size() == 5);
  std::vector<std::string> names;
  for (const PlannedRecording& one : plan.recordings)
    names.push_back(one.source.name().substr(one.source.name().rfind('/') + 1));
  CHECK(names == std::vector<std::string>{"book.xlsx#Trial 1", "book.xlsx#Trial 2", "sides.csv#left", "sides.csv#right",
                                          "one.csv"});
  CHECK_NOTHROW(refuse_repeated(plan, "--joint"));
  const RecordingPlan twice = plan_of_text(folder,
                                           "participant_id\tfile\tsection\tinvert\nA\tbook.xlsx\tTrial 1\tsway\n"
                                           "A\tbook.xlsx\tTrial 1\tn/a\n",
                                           {"book.xlsx"}, Choice::by_sheet);
  check_error([&] { refuse_repeated(twice, "--joint"); }, Code::setting_conflict, "--joint");
}
