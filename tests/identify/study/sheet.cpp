// A study's sheet: its columns, cells, names in NFC and NFD, and the recordings of its lines.
#include "identify/study/sheet.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "identify/study/detail/path_match.hpp"
#include "identify/study/detail/text_key.hpp"
#include "identify/study/find_recordings.hpp"
#include "identify/study/joint_groups.hpp"
#include "identify/study/plan_groups.hpp"
#include "identify/study/reading_option.hpp"
#include "identify/study/recording_plan.hpp"
#include "identify/study/sidecar.hpp"
#include "identify/study/spreadsheet.hpp"
#include "identify/study/study_results.hpp"
#include "sim/segments.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::test;

namespace {

using Likeness = PathKey::Likeness;

Likeness likeness(const std::string& path, const std::string& end) {
  return PathKey(path).ends_with(PathKey(end));
}

/// The sources of files, each with another content.
std::vector<RecordingSource> sources(const TemporaryFolder& folder, const std::vector<std::string>& names) {
  std::vector<RecordingSource> all;
  for (const std::string& name : names) {
    std::filesystem::create_directories((folder / name).parent_path());
    all.emplace_back(write_text(folder / name, name));
  }
  return all;
}

RecordingPlan plan_of_text(const TemporaryFolder& folder, const std::string& sheet,
                           const std::vector<std::string>& names, Choice choice) {
  const std::filesystem::path path = write_text(folder / "participants.tsv", sheet);
  return make_plan(read_sheet(path), sources(folder, names), choice, {});
}

/// Checks an error that a line or a recording has: its code, and a fact in its text.
void check_has(const std::optional<Error>& error, Code code, const std::string& fact,
               const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  REQUIRE_MESSAGE(error, "called in " << file << ", line " << line);
  check_error([&] { throw *error; }, code, fact, file, line);
}

}  // namespace

TEST_CASE("text_key: case and the form of accents do not count, letters do") {
  CHECK(text_key("J\u00FCrgen \u00C4RGER") == text_key("ju\u0308rgen a\u0308rger"));
  CHECK(text_key("\u0141\u00D3D\u0179") == text_key("\u0142o\u0301dz\u0301"));
  CHECK(text_key("\u0394\u0416") == text_key("\u03B4\u0436"));
  CHECK(text_key("u") != text_key("\u00FC"));
  CHECK(text_key("\u00E9") != text_key("\u00E8"));
  CHECK(text_key("a\xFF\xC3") == "a\xFF\xC3");  // no UTF-8
  CHECK(text_key("\xF0\x9F\x98\x80") == "\xF0\x9F\x98\x80");
  CHECK(column_key("Participant ID") == column_key("participant_id"));
  CHECK(column_key("Height (cm)") == "heightcm");
}

TEST_CASE("path_match: how alike a path and a cell are") {
  CHECK(likeness("a/b/trial.csv", "trial.csv") == Likeness::exact);
  CHECK(likeness("a/b/trial.csv", "b/trial.csv") == Likeness::exact);
  CHECK(likeness("a/b/trial.csv", "./b\\trial.csv") == Likeness::exact);
  CHECK(likeness("a/B/Trial.CSV", "b/trial.csv") == Likeness::forgiving);
  CHECK(likeness("a/Pru\u0308f 1.csv", "Pr\u00FCf 1.csv") == Likeness::forgiving);
  CHECK(likeness("a/b/trial.csv", "b/trial.mat") == Likeness::without_ending);
  CHECK(likeness("a/b/trial.csv", "trial") == Likeness::without_ending);
  CHECK(likeness("a/b/trial.csv", "c/trial.csv") == Likeness::none);
  CHECK(likeness("a/b/trial.csv", "rial.csv") == Likeness::none);
  CHECK(likeness("trial.csv", "b/trial.csv") == Likeness::none);
  CHECK(likeness("long.csv#2", "long.csv#2") == Likeness::exact);
  CHECK(likeness("long.csv#2", "long.csv#1") == Likeness::none);
  CHECK(likeness("long.csv", "") == Likeness::none);
}

TEST_CASE("read_sheet: columns by BIDS' names, units, decimal commas, missing values") {
  const TemporaryFolder folder;
  const StudySheet sheet = read_sheet(write_text(
      folder / "s.csv",
      "\xEF\xBB\xBFParticipant ID;File;Group;age;Height (cm);Weight_kg;Begin;Invert;Hand\r\n"
      "P1;a.csv;patients;71;175;\"70,5\";2,5;sway;left\r\n\r\nP2;;n/a;n/a;1,62;N/A;;;\"a;b\"\r\n;;;;;;;;\r\n"));
  CHECK(sheet.columns == std::vector<std::string>{"age", "Hand"});
  REQUIRE(sheet.lines.size() == 2);
  const SheetLine &first = sheet.lines[0], &second = sheet.lines[1];
  CHECK(first.entry == SheetEntry{"P1", "", "patients", "", {"71", "left"}});
  CHECK(first.file == "a.csv");
  CHECK(first.mass_kg == 70.5);
  CHECK(first.height_m == 1.75);
  CHECK(first.reading.size() == 2);
  CHECK_FALSE(first.error);
  CHECK(second.number == 4);
  CHECK(second.entry == SheetEntry{"P2", "", "", "", {"", "a;b"}});
  CHECK(second.height_m == 1.62);
  CHECK_FALSE(second.mass_kg);
  CHECK(sheet.locate(second) == (folder / "s.csv").string() + ", line 4");

  const StudySheet wrong =
      read_sheet(write_text(folder / "w.tsv",
                            "participant_id\theight\tweight\tunit\nA\t17\t70\tdeg\nB\t1.7\tx\tdeg\n"
                            "C\t1.7\t70\tfeet\nD\t1.7\t70\tmm\n\t1.7\t70\tdeg\n"));
  REQUIRE(wrong.lines.size() == 5);
  check_has(wrong.lines[0].error, Code::value_invalid, "line 2, height: '17'");
  check_has(wrong.lines[1].error, Code::value_invalid, "line 3, weight: 'x'");
  check_has(wrong.lines[2].error, Code::value_invalid, "feet");
  CHECK_FALSE(wrong.lines[3].error);
  check_has(wrong.lines[4].error, Code::value_missing, "line 6");

  check_error([&] { read_sheet(folder / "none.tsv"); }, Code::file_missing, "none.tsv");
  const auto refused = [&](const std::string& text, Code code) {
    check_error([&] { read_sheet(write_text(folder / "r.tsv", text)); }, code, "r.tsv");
  };
  refused("name\tage\nA\t3\n", Code::column_missing);
  refused("participant_id\tsubject\nA\tB\n", Code::column_ambiguous);
  refused("participant_id\tage\tAGE\nA\t3\t3\n", Code::column_ambiguous);
  refused("participant_id\tage\n", Code::file_empty);
  for (const char* column : {"weight_st", "Height (ft)", "body_mass_g", "Weight in stone", "Gewicht (Pfund)"})
    refused(std::string("participant_id\t") + column + "\nA\t6\n", Code::unit_unknown);

  const SheetLine in_pounds =
      read_sheet(write_text(folder / "lb.tsv", "ID\tweight_lb\tHeight (in)\nA\t154\t70\n")).lines.at(0);
  CHECK(near(in_pounds.mass_kg.value(), 154 * 0.45359237, 1e-15));
  CHECK(near(in_pounds.height_m.value(), 70 * 0.0254, 1e-15));
  const SheetLine in_words =
      read_sheet(write_text(folder / "in.csv", "ID,Body weight (pounds),Height in inches\nA,154,70\n")).lines.at(0);
  CHECK(in_words.mass_kg == in_pounds.mass_kg);
  CHECK(in_words.height_m == in_pounds.height_m);
  const SheetLine german =
      read_sheet(write_text(folder / "de.csv",
                            "Proband;Gruppe;Bedingung;Sitzung;Gr\u00f6\u00dfe (cm);Gewicht [kg];Datei\n"
                            "A;alt;Augen zu;1;170;70,5;a.csv\n"))
          .lines.at(0);
  CHECK(german.entry == SheetEntry{"A", "1", "alt", "Augen zu", {}});
  CHECK(german.height_m == 1.7);
  CHECK(german.mass_kg == 70.5);
  CHECK(german.file == "a.csv");
}

TEST_CASE("read_spreadsheet: a quote within a cell is text, and one without its pair is an error") {
  const TemporaryFolder folder;
  using Rows = std::vector<std::vector<std::string>>;
  const auto rows = [&](const std::string& text) { return read_spreadsheet(write_text(folder / "q.tsv", text)); };
  // Inches: the lines between two of them stay.
  CHECK(rows("ID\tremark\nS1\tfoam 3\"\nS2\tn/a\nS3\tfoam 3\"\n") ==
        Rows{{"ID", "remark"}, {"S1", "foam 3\""}, {"S2", "n/a"}, {"S3", "foam 3\""}, {""}});
  CHECK(rows("a,b\n1, \"x, y\" \n2,\"\"\"x\"\" y\"\n3,\"x\" y") ==
        Rows{{"a", "b"}, {"1", "x, y"}, {"2", "\"x\" y"}, {"3", "x y"}});
  CHECK(rows("a,b\n\"two\nlines, one cell\",1\n\"\",\n") ==
        Rows{{"a", "b"}, {"two\nlines, one cell", "1"}, {"", ""}, {""}});
  for (const char* text : {"a,b\n1,2\n3,\"x\n4,5\n", "a,b\n1,2\n3,\"x\n4,y\n5,\"z\n",
                           "a\tb\n1\t2\n3\t\"\n4\t\"\n5\tx\n", "a,b\n\"two\nlines\",2\n3,\"", "a,b\n1,2\n3,\"\"\""}) {
    CAPTURE(text);
    const bool is_later = contains(text, "lines");
    check_error([&] { rows(text); }, Code::table_unclear, is_later ? "q.tsv, line 4" : "q.tsv, line 3");
  }
}

TEST_CASE("read_sheet: a sidecar of BIDS gives the units of weights and heights whose names have none") {
  const TemporaryFolder folder;
  const auto path = write_text(folder / "participants.tsv", "participant_id\tweight\theight\tage\nA\t154\t70\t60\n");
  const auto with = [&](const std::string& sidecar) {
    write_text(folder / "participants.json", sidecar);
    return read_sheet(path).lines.at(0);
  };
  CHECK(sidecar_of(path) == std::nullopt);
  const SheetLine found =
      with(R"({"weight": {"Units": "lb"}, "height": {"Description": "h", "Units": "[in_i]"}, "age": {"Units": "x"}})");
  CHECK(near(found.mass_kg.value(), 154 * 0.45359237, 1e-15));
  CHECK(near(found.height_m.value(), 70 * 0.0254, 1e-15));
  CHECK(sidecar_of(path) == folder / "participants.json");
  CHECK(with(R"({"weight": {"Units": "kg"}, "height": 5})").mass_kg == 154.0);
  check_error([&] { with(R"({"weight": {"Units": "stone"}})"); }, Code::unit_unknown, "\"stone\"");
  check_error([&] { with("{"); }, Code::setting_malformed, "participants.json");
  // A unit in the name counts, and so does only the sidecar of a sheet that BIDS names.
  write_text(folder / "participants.json", R"({"weight_kg": {"Units": "stone"}})");
  write_text(path, "participant_id\tweight_kg\nA\t70\n");
  CHECK(read_sheet(path).lines.at(0).mass_kg == 70.0);
  write_text(folder / "people.json", R"({"weight": {"Units": "stone"}})");
  CHECK(read_sheet(write_text(folder / "people.tsv", "ID\tweight\nA\t70\n")).lines.at(0).mass_kg == 70.0);
  CHECK(sidecar_of(folder / "people.tsv") == std::nullopt);
}

TEST_CASE("set_reading_option: every option, and values it does not have") {
  ReadOptions made;
  for (const auto& [name, value] : std::initializer_list<std::pair<const char*, const char*>>{{"column", "COM_x"},
                                                                                              {"section", "2"},
                                                                                              {"leg_column", "l"},
                                                                                              {"trunk_column", "t"},
                                                                                              {"hip_column", "h"},
                                                                                              {"shoulder_column", "s"},
                                                                                              {"ankle_column", "a"},
                                                                                              {"unit", "mm"},
                                                                                              {"rate", "100"},
                                                                                              {"com_height", "0.9"},
                                                                                              {"skip_lines", "3"},
                                                                                              {"missing_value", "-1"},
                                                                                              {"fill_gaps", "0.1"},
                                                                                              {"begin", "2"},
                                                                                              {"tilt_column", "p"},
                                                                                              {"tilt_unit", "rad"},
                                                                                              {"invert", "both"},
                                                                                              {"detrend", "linear"}})
    set_reading_option(made, name, value, "here");
  const recording::RecordingOptions& reading = made.recording;
  CHECK(reading.column == "COM_x");
  CHECK(reading.section == "2");
  CHECK((reading.leg_column == "l" && reading.trunk_column == "t" && reading.hip_column == "h"));
  CHECK((reading.shoulder_column == "s" && reading.ankle_column == "a"));
  CHECK((reading.metres_per_unit == 0.001 && !reading.unit));
  CHECK((reading.rate_hz == 100.0 && reading.com_height_m == 0.9 && reading.skip_lines == 3));
  CHECK((reading.missing_value == -1.0 && reading.fill_gaps_s == 0.1 && made.trial.start_s == 2.0));
  CHECK((reading.tilt_column == "p" && reading.find_tilt && reading.tilt_unit == recording::Unit::radian));
  CHECK((reading.invert_sway && reading.invert_tilt));
  CHECK(made.trial.detrend == recording::Detrend::linear);
  set_reading_option(made, "tilt_column", "none", "here");
  CHECK((!made.recording.find_tilt && made.recording.tilt_column.empty()));
  for (const auto& [name, value] : std::initializer_list<std::pair<const char*, const char*>>{{"unit", "feet"},
                                                                                              {"tilt_unit", "mm"},
                                                                                              {"invert", "all"},
                                                                                              {"detrend", "mean"},
                                                                                              {"rate", "0"},
                                                                                              {"rate", "x"},
                                                                                              {"begin", "-1"},
                                                                                              {"begin", "1 s"}})
    check_error([&, &n = name, &v = value] { set_reading_option(made, n, v, "here"); }, Code::value_invalid, "here");
  check_error([&] { set_reading_option(made, "nothing", "1", "here"); }, Code::setting_unknown, "nothing");
  CHECK(find_reading_option("Tilt column") == "tilt_column");
  CHECK(find_reading_option("leg").empty());
}

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

TEST_CASE("read_sheet: a person in two groups is refused with both lines, whatever the session") {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    return read_sheet(write_text(folder / "g.csv", "participant_id,session,group,file\n" + text)).lines.size();
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

TEST_CASE("plan_of: two bodies and two ages of a person in one session are warnings of both recordings") {
  const TemporaryFolder folder;
  const std::vector<std::string> files{"a.csv", "b.csv", "c.csv", "d.csv"};
  const auto planned = [&](const std::string& sheet) {
    return plan_of_text(folder, sheet, files, Choice::by_sheet).recordings;
  };
  const auto codes = [](const PlannedRecording& one) {
    std::vector<std::string> all;
    for (const Warning& warning : one.warnings) {
      CHECK(warning.severity == Severity::caution);
      all.push_back(warning.code);
    }
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

  // Without sessions the values must agree; units, rounding and empty cells do not count.
  const auto without = planned(
      "ID\tfile\tweight\theight\tAge (years)\nP1\ta.csv\t70\t175\t60\nP1\tb.csv\t70,0\t1.75\t60.0\n"
      "P1\tc.csv\tn/a\tn/a\tn/a\nP1\td.csv\t70\t1.74\tn/a\n");
  CHECK(codes(without[0]) == Codes{"two_bodies"});
  CHECK(codes(without[1]) == Codes{"two_bodies"});
  CHECK(codes(without[2]).empty());
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

TEST_CASE("StudySheet::reader_of: columns by any spelling; joint_groups: persons and conditions by any case") {
  const TemporaryFolder folder;
  const std::filesystem::path path = write_text(
      folder / "people.csv", "Subject,file,Eyes\nA,a.csv,open\na,b.csv,Open\nB,c.csv,open\na,d.csv,closed\n");
  const StudySheet sheet = read_sheet(path);
  CHECK(sheet.reader_for("participant_id")(sheet.lines[0].entry) == "A");
  CHECK(sheet.reader_for("eyes")(sheet.lines[1].entry) == "Open");
  check_error([&] { sheet.reader_for("shoe"); }, Code::column_missing, "shoe");
  check_error([&] { sheet.reader_for("file"); }, Code::column_missing, "file");
  CHECK(names_participants("Patient ID"));
  CHECK_FALSE(names_participants("group"));
  const RecordingPlan plan =
      make_plan(sheet, sources(folder, {"a.csv", "b.csv", "c.csv", "d.csv"}), Choice::by_sheet, {});
  const std::vector<FitGroup> groups = joint_groups(plan, "subject", "eyes");
  REQUIRE(groups.size() == 1);
  CHECK(groups[0].recordings == std::vector<std::size_t>{0, 1, 3});
  CHECK(groups[0].conditions == std::vector<std::string>{"open", "open", "closed"});
  check_error([&] { joint_groups(make_plan(sources(folder, {"a.csv"}), {}), "subject", ""); }, Code::setting_conflict);
}

TEST_CASE("recordings_below: files that may be recordings, by name, not what describes them") {
  const TemporaryFolder folder;
  sources(folder, {"b/t.CSV", "a.mat", "b/.hidden.csv", ".git/x.csv", "participants.tsv", "b/sub-1_channels.tsv",
                   "README.txt", "report.pdf", "c.trc"});
  std::vector<std::string> found;
  for (const std::filesystem::path& path : recordings_below(folder.path()))
    found.push_back(path.lexically_relative(folder.path()).string());
  CHECK(found == std::vector<std::string>{"a.mat", "b/t.CSV", "c.trc"});
  CHECK(recordings_below(folder / "none").empty());
}

TEST_CASE("groups of a plan: a sheet without groups, and a wrong cell, are named instead of a number of groups") {
  const TemporaryFolder folder;
  const auto plan = [&](const std::string& sheet) {
    return plan_of_text(folder, sheet, {"a.csv", "b.csv"}, Choice::by_sheet);
  };
  const RecordingPlan without = plan("ID\tfile\tdiagnosis\nA\ta.csv\tx\nB\tb.csv\ty\n");
  check_error([&] { groups_of_plan(without, true); }, Code::column_missing, "ID, file, diagnosis");
  CHECK(groups_of_plan(without, false).members.size() == 2);
  const RecordingPlan wrong = plan("ID\tfile\tGroup\tweight\theight\nA\ta.csv\tx\t70\t17\nB\tb.csv\tx\t70\t175\n");
  const GroupTable groups = groups_of_plan(wrong, true);
  check_error([&] { refuse_groups(groups.members, "here", 2, &wrong); }, Code::value_invalid, "'17'");
  check_error([&] { refuse_groups(groups.members, "here", 2); }, Code::setting_out_of_range, "1 group");
  refuse_groups(groups.members, "here", 1, &wrong);
}

TEST_CASE("groups of a plan: sessions, conditions and covariates of its sheet") {
  const TemporaryFolder folder;
  const std::vector<std::string> files{"a.csv", "b.csv", "c.csv", "d.csv"};
  const RecordingPlan plan = plan_of_text(folder,
                                          "participant_id\tgroup\tsession\tcondition\tfile\tage\tweight\theight\tsex\n"
                                          "A\tx\t1\topen\ta.csv\t60,5\t70\t175\tF\n"
                                          "a\tX\t2\tOpen\tb.csv\t61\t71\t175\tM\n"
                                          "B\ty\t1\topen\tc.csv\tn/a\tn/a\tn/a\tn/a\n"
                                          "C\tn/a\tn/a\tn/a\td.csv\t50\t80\t1.8\tF\n",
                                          files, Choice::by_sheet);
  const std::vector<double> ages = read_covariate(plan, "Age"), weights = read_covariate(plan, "weight_kg");
  CHECK(ages[0] == 60.5);
  CHECK(std::isnan(ages[2]));
  CHECK(weights[3] == 80.0);
  CHECK(read_covariate(plan, "body height")[0] == 1.75);
  check_error([&] { read_covariate(plan, "sex"); }, Code::value_invalid, "'F'");
  check_error([&] { read_covariate(plan, "shoe"); }, Code::column_missing, "shoe");
  const auto steps = [&](const std::string& cells) {  // of four recordings
    return read_covariate(plan_of_text(folder, "steps\tfile\n" + cells, files, Choice::by_sheet), "steps");
  };
  check_error([&] { steps("7,500\ta.csv\n12,300\tb.csv\n980\tc.csv\nn/a\td.csv\n"); }, Code::value_invalid, "'7,500'");
  CHECK(steps("7,500\ta.csv\n12,3\tb.csv\n980\tc.csv\n0\td.csv\n") == std::vector<double>{7.5, 12.3, 980.0, 0.0});
  CHECK(steps("0,500\ta.csv\n1,250\tb.csv\n2\tc.csv\n1\td.csv\n") == std::vector<double>{0.5, 1.25, 2.0, 1.0});
  const RecordingPlan without = make_plan(sources(folder, {"a.csv"}), {});
  check_error([&] { read_covariate(without, "age"); }, Code::setting_missing, "covariates");

  GroupTable groups = groups_of_plan(plan, true);
  CHECK(groups.participant_column == "participant_id");
  CHECK(groups.members[1].group == "x");
  CHECK(groups.members[1].participant == "A");
  CHECK(groups.members[3].group.empty());
  refuse_groups(groups.members, "here");
  check_error([&] { refuse_groups(groups.members, "here", 3); }, Code::setting_out_of_range, "2 groups");
  CHECK(compare_within("session", plan, groups) == 0);
  CHECK(groups.members[1].cell() == "x, 2");
  CHECK(groups.members[3].cell().empty());
  check_error([&] { compare_within("condition", plan, groups); }, Code::value_missing, "1 condition");
  check_error([&] { compare_within("sex", plan, groups); }, Code::setting_unknown, "sex");
  check_error([&] { compare_within("session", without, groups); }, Code::setting_missing, "within");
  add_covariate("age", plan, groups);
  CHECK(groups.covariates == std::vector<std::string>{"age"});
  CHECK(groups.members[1].covariates == std::vector<double>{61.0});
  check_error([&] { add_covariate("height", plan, groups); }, Code::value_missing, "height");  // C is in no group

  GroupTable all = groups_of_plan(plan, false);
  CHECK(compare_within("session", plan, all) == 1);
  CHECK(all.members[0].cell() == "1");
  CHECK(all.members[3].cell().empty());
  const std::vector<FitGroup> joint = joint_groups(plan, "participant_id", "");
  check_error([&] { refuse_joint_cells(all, joint); }, Code::setting_conflict, "joint");
  refuse_joint_cells(groups_of_plan(plan, true), joint);
  refuse_joint_cells({}, joint);
  GroupTable one_cell = groups_of_plan(plan, true);
  one_cell.members[2].group = "x";
  check_error(
      [&] {
        refuse_joint_cells(one_cell, std::vector<FitGroup>{{{0, 2}, {}}});
      },
      Code::setting_conflict, "\"B\"");
}
