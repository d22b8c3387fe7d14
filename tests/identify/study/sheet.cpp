// A study's sheet: its columns, cells and names in NFC and NFD, and the options of its lines.
#include "identify/study/sheet.hpp"

#include <doctest/doctest.h>

#include "identify/study/detail/path_match.hpp"
#include "identify/study/detail/spreadsheet.hpp"
#include "identify/study/detail/text_key.hpp"
#include "identify/study/reading_option.hpp"
#include "identify/study/recording_plan.hpp"
#include "identify/study/sidecar.hpp"
#include "tests/helpers.hpp"
#include "tests/identify/study/sheet_files.hpp"

using namespace decid;
using namespace decid::test;

namespace {

using Likeness = PathKey::Likeness;

Likeness likeness(const std::string& path, const std::string& end) {
  return PathKey(path).ends_with(PathKey(end));
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

TEST_CASE("read_sheet: a recording is not a sheet, and a sheet not a recording") {
  const TemporaryFolder folder;
  std::string samples = "subject,time,sway_deg\n", visits = "subject,group,time\n";
  for (int k = 0; k < 200; ++k) {
    samples += "1," + std::to_string(k % 150) + ",0.1\n";  // two trials
    visits += "p" + std::to_string(k) + ",a," + std::to_string(7 * k % 24) + "\n";
  }
  const auto recording = write_text(folder / "r.csv", samples), sheet = write_text(folder / "s.csv", visits);
  check_error([&] { read_sheet(recording); }, Code::file_unsupported, "r.csv");
  CHECK(read_sheet(sheet).lines.size() == 200);
  CHECK_FALSE(looks_like_sheet(recording));
  const auto small = write_text(folder / "t.csv", "Proband,Gruppe,Alter\n1,a,70\n2,b,71\n");
  CHECK(looks_like_sheet(small));
  CHECK_FALSE(looks_like_sheet(folder / "none.csv"));
  const Error lists = error_of([&] { read_sheet(small).reader_for("age"); });
  CHECK(lists.code() == Code::column_missing);
  CHECK(lists.remedy().find("Alter") != std::string::npos);
  const recording::ProtocolPlan plan(sim::Protocol{});
  CHECK(read_source(plan, small, {}).error.value().code() == Code::file_unsupported);
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

TEST_CASE("set_reading_option: every option, and values it does not have") {
  ReadOptions made;
  using Settings = std::vector<std::pair<std::string, std::string>>;
  const Settings given{{"column", "COM_x"},  {"section", "2"},         {"leg_column", "l"},   {"trunk_column", "t"},
                       {"hip_column", "h"},  {"shoulder_column", "s"}, {"ankle_column", "a"}, {"unit", "mm"},
                       {"rate", "100"},      {"com_height", "0.9"},    {"skip_lines", "3"},   {"missing_value", "-1"},
                       {"fill_gaps", "0.1"}, {"begin", "2"},           {"tilt_column", "p"},  {"tilt_unit", "rad"},
                       {"invert", "both"},   {"detrend", "linear"}};
  for (const auto& [name, value] : given) set_reading_option(made, name, value, "here");
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
  set_reading_option(made, "tilt_column", "None", "here");
  CHECK((!made.recording.find_tilt && made.recording.tilt_column.empty()));
  const auto inverted = [](const std::string& word) {
    ReadOptions one;
    set_reading_option(one, "invert", word, "here");
    return std::pair(one.recording.invert_sway, one.recording.invert_tilt);
  };
  for (const char* word : {"sway", "Sway", "yes", "YES", "TRUE", "ja"}) CHECK(inverted(word) == std::pair(true, false));
  for (const char* word : {"none", "None", "no", "No", "FALSE", "Nein"})
    CHECK(inverted(word) == std::pair(false, false));
  CHECK(inverted("Tilt") == std::pair(false, true));
  CHECK(inverted("BOTH") == std::pair(true, true));
  set_reading_option(made, "detrend", "Offset", "here");
  CHECK(made.trial.detrend == recording::Detrend::offset);
  set_reading_option(made, "detrend", "No", "here");
  CHECK(made.trial.detrend == recording::Detrend::none);
  set_reading_option(made, "unit", "Deg", "here");
  set_reading_option(made, "tilt_unit", "MRAD", "here");
  CHECK((made.recording.unit == recording::Unit::degree && made.recording.tilt_unit == recording::Unit::milliradian));
  const Settings wrong{{"unit", "feet"},    {"tilt_unit", "mm"}, {"invert", "all"},
                       {"detrend", "mean"}, {"detrend", "yes"},  {"rate", "0"},
                       {"rate", "x"},       {"begin", "-1"},     {"begin", "1 s"}};
  for (const auto& [name, value] : wrong)
    check_error([&, &n = name, &v = value] { set_reading_option(made, n, v, "here"); }, Code::value_invalid, "here");
  check_error([&] { set_reading_option(made, "nothing", "1", "here"); }, Code::setting_unknown, "nothing");
  CHECK(find_reading_option("Tilt column") == "tilt_column");
  CHECK(find_reading_option("leg").empty());
}

TEST_CASE("read_sheet: words of clinical sheets are carried along, and noted where their cells look like settings") {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) { return read_sheet(write_text(folder / "s.csv", text)); };
  for (const char* cells : {"left,right,sprained,no", "98,102.5,sound,0", "98 cm,L/R,o.B.,12", "no,yes,n/a,yes"}) {
    CAPTURE(cells);
    const StudySheet sheet = read("id,Hip,shoulder,Ankle,missing\nA," + std::string(cells) + "\n");
    CHECK(sheet.columns == std::vector<std::string>{"Hip", "shoulder", "Ankle", "missing"});
    CHECK(sheet.lines[0].reading.empty());
    CHECK_FALSE(sheet.lines[0].error.has_value());
    CHECK(sheet.notes.empty());
  }
  CHECK(read("id,Hip,shoulder,Ankle,missing\nA,HIP_x,RSHO:X,ank2,-999\n").notes.size() == 4);
  const auto notes = [&](const std::string& column, const std::string& one, const std::string& other) {
    const StudySheet found = read("id," + column + "\nA," + one + "\nB," + other + "\n");
    CHECK(found.columns == std::vector<std::string>{column});
    return found.notes;
  };
  REQUIRE(notes("start", "0.5", "n/a").size() == 1);
  CHECK(notes("start", "0.5", "n/a")[0].ends_with("column start is carried along; begin is the setting"));
  CHECK(notes("start", "3.5.2024", "10:30").empty());
  CHECK(notes("Leg", "left", "R").empty());
  CHECK(notes("leg", "leg_deg", "leg_deg").size() == 1);
  CHECK(notes("trial", "1", "2").empty());
  CHECK(notes("trial", "run", "run").size() == 1);
  const std::vector<RecordingSource> sources{RecordingSource(write_text(folder / "a.csv", "a"))};
  CHECK(make_plan(read("file,start\na.csv,2\n"), sources, Choice::by_call, {}).notes == notes("start", "2", "3"));
}

TEST_CASE("read_sheet: many names of the person's column; the surest one counts") {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& names) {
    return read_sheet(write_text(folder / "s.csv", "file;" + names + "\na.csv;P1;P2\n"));
  };
  for (const char* name :
       {"Subject No", "SUBJECT-NR.", "VP-Nr", "vpnr", "Vp_Nr.", "Proband Nr", "participant no", "Pat.-ID", "Subject #",
        "Subject N\u00B0", "Versuchsperson", "Patient:", "Code", "Pseudonym"}) {
    CAPTURE(name);
    const StudySheet sheet = read(std::string(name) + ";age");
    CHECK(sheet.participant_column == name);
    CHECK(sheet.lines[0].entry.participant == "P1");
    CHECK(sheet.columns == std::vector<std::string>{"age"});
  }
  for (const char* name : {"Number", "part 1", "subjective score", "weight %"})
    CHECK(read(std::string(name) + ";age").participant_column.empty());
  const StudySheet both = read("Code;Subject No");
  CHECK(both.lines[0].entry.participant == "P2");
  CHECK(both.lines[0].entry.cells == std::vector<std::string>{"P1"});
  CHECK(both.reader_for("code")(both.lines[0].entry) == "P1");
  CHECK(both.reader_for("subject")(both.lines[0].entry) == "P2");
  CHECK(read("VP-Nr;participant_id").lines[0].entry.participant == "P2");
  // The first of equals counts, numbers before names, and the others are carried along.
  for (const char* names : {"patient nr;patient name", "VP-Nr;VP-Code", "VP-Nr;Subject No", "code;pseudonym"}) {
    CAPTURE(names);
    const StudySheet found = read(names);
    CHECK(found.lines[0].entry.participant == "P1");
    CHECK(found.lines[0].entry.cells == std::vector<std::string>{"P2"});
  }
  CHECK(read("patient name;patient nr").lines[0].entry.participant == "P2");
  CHECK(read("pseudonym;patient name").lines[0].entry.participant == "P2");
  for (const char* same : {"VP-Nr;vp nr", "id;participant"}) check_error([&] { read(same); }, Code::column_ambiguous);
}

TEST_CASE("read_sheet: marks of no person, session or group; whole numbers with a point and zeros") {
  const TemporaryFolder folder;
  const StudySheet sheet = read_sheet(write_text(folder / "s.tsv",
                                                 "file\tid\tsession\tgroup\tcondition\tnote\n"
                                                 "a.csv\t-\t.\t-\t-\t-\n"
                                                 "b.csv\t1.0\t1.0\t0,0\t-2.00\t1.0\n"
                                                 "c.csv\t1.5\t1.5\t.\t1.0a\t.\n"
                                                 "d.csv\t2\t1,00\t1.000\t1,000\t.\n"));
  CHECK(sheet.lines[0].entry == SheetEntry{"", "", "", "-", {"-"}});  // medication may be + and -
  CHECK(sheet.lines[1].entry == SheetEntry{"1.0", "1", "0", "-2", {"1.0"}});
  CHECK(sheet.lines[2].entry == SheetEntry{"1.5", "1.5", "", "1.0a", {"."}});
  CHECK(sheet.lines[3].entry == SheetEntry{"2", "1", "1", "1,000", {"."}});  // perhaps a thousand
}

TEST_CASE("read_spreadsheet: no-break blanks and characters of no width are blanks and nothing, except in file names") {
  const TemporaryFolder folder;
  const auto rows =
      read_spreadsheet(write_text(folder / "n.csv",
                                  "\xEF\xBB\xBF\xEF\xBB\xBF"
                                  "file,group\u00A0,note\na\u00A0b.csv\u00A0,old\u00A0men\u202F,\u200Bx\n"));
  CHECK(rows[0] == std::vector<std::string>{"file", "group", "note"});
  CHECK(rows[1] == std::vector<std::string>{"a\u00A0b.csv", "old men", "x"});
}
