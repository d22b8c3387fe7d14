// Columns of MAT-files as programs export them, and several recordings in one: files that make.py writes with SciPy.
#include "recording/formats/detail/mat/mat_columns.hpp"

#include "recording/formats/detail/mat/mat.hpp"
#include "recording/recording.hpp"
#include "recording/table/columns.hpp"
#include "sim/protocol/protocol.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;
using Kind = MatVariable::Kind;

namespace {

std::filesystem::path made(const char* name) {
  return std::filesystem::path(DECID_SOURCE_DIR) / "tests/recording/mat" / name;
}

auto reading(const char* name, const RecordingOptions& options = {}) {
  return [name, options] { read_recording(made(name), options); };
}

void check_degrees(const std::vector<double>& rad, double factor) {
  REQUIRE(rad.size() == 20);
  for (std::size_t k = 0; k < rad.size(); ++k)
    CHECK(near(rad[k], factor * static_cast<double>(k + 1) / 8.0 * sim::rad_per_deg, 1e-14));
}

/// 1/8, 2/8, ... 20/8 degrees at 50 Hz, times `factor`.
Recording check_made(const char* name, const RecordingOptions& options = {}, double factor = 1.0,
                     double rate_hz = 50.0) {
  INFO(name);
  Recording recording = read_recording(made(name), options);
  CHECK(near(recording.rate_hz, rate_hz, 1e-12));
  check_degrees(recording.signals.at(com_sway).rad, factor);
  return recording;
}

void check_tilt(const Recording& recording) {
  REQUIRE(recording.signals.find(platform_tilt) != nullptr);
  check_degrees(recording.signals.at(platform_tilt).rad, -2.0);
}

MatVariable numbers(const std::string& name, std::size_t height, std::size_t width, std::size_t pages = 1) {
  MatVariable variable{.name = name, .height = height, .width = width, .pages = pages};
  for (std::size_t i = 0; i < variable.count(); ++i) variable.values.push_back(static_cast<double>(i));
  return variable;
}

MatVariable text(const std::string& name, std::vector<std::string> rows) {
  return {.name = name, .kind = Kind::text, .height = rows.size(), .width = 1, .text = std::move(rows)};
}

MatVariable holding(Kind kind, const std::string& name, std::vector<MatVariable> fields, std::size_t count = 1) {
  return {.name = name, .kind = kind, .height = 1, .width = count, .fields = std::move(fields)};
}

std::vector<std::string> paths(const MatColumns& made) {
  std::vector<std::string> all;
  for (const MatColumn& column : made.columns) all.push_back(column.path);
  return all;
}

std::vector<std::string> names(const MatColumns& made) {
  std::vector<std::string> all;
  for (const MatColumn& column : made.columns) all.push_back(column.name);
  return all;
}

using Strings = std::vector<std::string>;

}  // namespace

TEST_CASE("arrays of structures, cells and pages: each element is a recording, with its own time and rate") {
  check_error(reading("struct_array.mat"), Code::column_ambiguous,
              "'trials(1).com_sway_deg', 'trials(2).com_sway_deg'");
  for (const auto& [trial, factor] : {std::pair{"1", 1.0}, std::pair{"2", 2.0}}) {
    check_made("struct_array.mat", {.trial_column = "trials", .trial = trial}, factor);
    check_made("cell.mat", {.trial_column = "data", .trial = trial}, factor);
    check_tilt(check_made("pages.mat", {.trial_column = "data", .trial = trial}, factor));
  }
  CHECK(read_recording(made("cell.mat"), {.trial_column = "data", .trial = "2"}).file.ends_with("cell.mat#2"));
  check_made("struct_array.mat", {.column = "trials(2).com_sway_deg"}, 2.0);
  check_made("cell.mat", {.column = "data{2}(:,2)", .rate_hz = 50.0}, 2.0);
  check_made("pages.mat", {.column = "data(:,1,2)"}, 2.0);
  CHECK(list_trials(made("struct_array.mat"), {.trial_column = "trials"}) == Strings{"1", "2"});
  CHECK(list_trials(made("wide.mat"), {.trial_column = "data"}) == Strings{"1", "2"});
  check_error(reading("cell.mat"), Code::column_ambiguous, "trial_column");
  check_error(reading("pages.mat"), Code::column_ambiguous, "trial_column");
  for (const char* none : {"0", "3", "", "1x", "-1"})
    check_error(reading("struct_array.mat", {.trial_column = "trials", .trial = none}), Code::setting_unknown);
  check_error([] { list_trials(made("struct_array.mat"), {.trial_column = "nothing"}); }, Code::column_missing,
              "'nothing'");
  check_error([] { list_trials(made("none.mat"), {.trial_column = "trials"}); }, Code::file_missing, "none.mat");
}

TEST_CASE("structures beside each other: the path says whose sway, its time is taken") {
  check_error(reading("two_structs.mat"), Code::column_ambiguous, "'S01.com_sway_deg', 'S02.com_sway_deg'");
  check_made("two_structs.mat", {.column = "S01.com_sway_deg"});
  check_made("two_structs.mat", {.column = "S02.com_sway_deg"}, 2.0, 100.0);
}

TEST_CASE("a column of trials in a MAT-file: refused, or each a recording") {
  check_error(reading("trial_column.mat"), Code::recording_ambiguous, "row 21");
  check_error(reading("trial_column.mat", {.rate_hz = 50.0}), Code::recording_ambiguous);
  CHECK(list_trials(made("trial_column.mat"), {.trial_column = "trial"}) == Strings{"3", "7"});
  check_made("trial_column.mat", {.trial_column = "trial", .trial = "3"});
  check_made("trial_column.mat", {.trial_column = "trial", .trial = "7"}, 2.0);
}

TEST_CASE("exports of Simulink, LabChart, AcqKnowledge and Qualisys have their names, units and rates") {
  check_tilt(check_made("simulink.mat"));
  CHECK(check_made("timeseries.mat").signals.at(com_sway).column == "lean (deg)");
  check_tilt(check_made("labelled.mat"));
  CHECK(check_made("acqknowledge.mat").signals.at(com_sway).column == "Sway (deg)");
  check_tilt(check_made("acqknowledge.mat"));
  check_error(reading("labchart.mat"), Code::column_ambiguous, "'block1.Sway (deg)', 'block2.Sway (deg)'");
  check_tilt(check_made("labchart.mat", {.trial_column = "block", .trial = "1"}));
  check_made("labchart.mat", {.column = "block2.Sway (deg)"}, 2.0, 25.0);
  const RecordingOptions marker{.column = "HIP X", .com_height_m = 0.9, .ankle_column = "ANK X"};
  check_made("qtm.mat", marker);
  // Analog signals have their own rate.
  const Recording analog = read_recording(made("qtm.mat"), {});
  CHECK(analog.rate_hz == 500.0);
  CHECK(analog.signals.at(com_sway).rad.size() == 200);
}

TEST_CASE("pages are read where the dimension of the samples is plain") {
  const auto columns = [](std::size_t height, std::size_t width, std::size_t pages) {
    return make_columns({numbers("x", height, width, pages)}, "f.mat");
  };
  const MatColumns tall = columns(30, 2, 3), wide = columns(2, 30, 3);
  REQUIRE(tall.columns.size() == 6);
  CHECK(tall.columns[3].path == "x(:,2,2)");
  CHECK(tall.columns[3].values[4] == 94.0);  // of sample 5, channel 2, page 2
  REQUIRE(wide.columns.size() == 6);
  CHECK(wide.columns[3].path == "x(2,:,2)");
  CHECK(wide.columns[3].values[4] == 69.0);
  CHECK(tall.arrays.front().elements == 3);
  CHECK(columns(2, 3, 30).columns.empty());
  CHECK(columns(30, 30, 3).columns.empty());
  CHECK(columns(30, 2, 30).columns.empty());
  CHECK(columns(103, 102, 99).columns.empty());  // more than any file's columns
  CHECK(columns(2, 3, 30).variables == "x (2 x 3 x 30 numbers)");
  CHECK(columns(2, 3, 30).unread == "x (2 x 3 x 30 numbers)");
  CHECK(paths(columns(1, 2, 30)) == Strings{"x(1,:)", "x(2,:)"});
  CHECK(paths(columns(1, 1, 30)) == Strings{"x"});
}

TEST_CASE("names for columns come from a list of as many; short vectors within arrays are none") {
  const auto cell = [](const Strings& words) {
    std::vector<MatVariable> inner;
    for (const std::string& word : words) inner.push_back(text("{1}", {word}));
    return holding(Kind::cell, "colheaders", inner, words.size());
  };
  CHECK(names(make_columns({numbers("data", 30, 2), cell({"t", "lean"})}, "f")) == Strings{"t", "lean"});
  CHECK(names(make_columns({numbers("data", 30, 2), cell({"t", "lean", "x"})}, "f")) ==
        Strings{"data(:,1)", "data(:,2)"});
  CHECK(names(make_columns({numbers("data", 2, 3), cell({"a", "b"})}, "f")) == Strings{"a", "b"});
  CHECK(names(make_columns({numbers("data", 30, 1), text("labels", {"lean"}), text("units", {"rad"})}, "f")) ==
        Strings{"lean (rad)"});
  CHECK(names(make_columns({numbers("data", 30, 1), text("labels", {"lean_rad"}), text("units", {"rad"})}, "f")) ==
        Strings{"lean_rad"});
  CHECK(names(make_columns({numbers("sway", 30, 1), text("labels", {"lean"})}, "f")) == Strings{"sway"});
  const auto element = [](std::size_t values) {
    return holding(Kind::structure, "(1)", {numbers("limits", values, 1)});
  };
  CHECK(make_columns({holding(Kind::structure, "s", {element(2), element(15)}, 2)}, "f").columns.empty());
  CHECK(make_columns({holding(Kind::structure, "s", {element(2), element(16)}, 2)}, "f").columns.size() == 1);
  CHECK(shared_levels({"a", "(1)", "b"}, {"a", "(1)", "c", "d"}) == 2);
}

TEST_CASE("an index at a name's end is no part of its unit") {
  for (const char* name : {"sway_rad(:,2)", "sway_rad(2,:)", "sway_rad(:,2,3)", "sway_rad{2}", "sway_rad{2}(:,1)"}) {
    CHECK(unit_in(name) == Unit::radian);
    CHECK(name_without_unit(name) == "sway");
  }
  for (const char* name : {"sway (2)", "(:,2)", "{2}", "sway(a:b)"}) CHECK_FALSE(unit_in(name));
}

TEST_CASE("unread variables that hold signals are named with their kind") {
  const MatVariable complex{.name = "z", .kind = Kind::complex, .height = 20, .width = 1};
  const MatVariable table{.name = "T", .kind = Kind::object, .text = {"table"}};
  const MatVariable four{.name = "x", .is_matrix = false};
  const MatVariable note = text("note", {"a"});
  CHECK(make_columns({complex, table, four, note}, "f").unread ==
        "z (20 x 1 complex), T (table object), x (more than three dimensions, numbers)");
  const TemporaryFolder folder;
  std::string bytes = read_text(made("v4.mat"));
  const std::size_t at = bytes.find("COM_x");
  REQUIRE(at != std::string::npos);
  bytes[at - 20] = 2;  // sparse, by the type of its variable
  bytes.resize(bytes.find("tilt_deg") - 20);
  check_error([&] { read_recording(write_text(folder / "f.mat", bytes), {}); }, Code::column_missing, "COM_x");
}

TEST_CASE("a user's own variables beside LabChart's are columns too, LabChart's own are not") {
  MatVariable begin = numbers("datastart", 1, 1), end = numbers("dataend", 1, 1);
  begin.values = {1.0}, end.values = {40.0};
  const MatColumns made = make_columns({numbers("data", 1, 40), begin, end, numbers("rangemin", 3, 1),
                                        numbers("com", 4, 5), numbers("com_sway_deg", 40, 1), numbers("time", 40, 1)},
                                       "lab.mat");
  CHECK(names(made) == Strings{"channel 1", "com_sway_deg", "time"});
}

TEST_CASE("LabChart's channels lie within its data, once each") {
  const auto labchart = [](double first, double last, double next) {
    MatVariable begin = numbers("datastart", 2, 1), end = numbers("dataend", 2, 1);
    begin.values = {first, next};
    end.values = {last, 40.0};
    return make_columns({numbers("data", 1, 40), begin, end}, "lab.mat");
  };
  CHECK(names(labchart(1, 20, 21)) == Strings{"channel 1", "channel 2"});
  CHECK(labchart(1, 20, 21).columns[1].values.front() == 20.0);
  CHECK(names(labchart(-1, -1, 21)) == Strings{"channel 2"});
  for (const auto& at : {std::tuple{1.0, 41.0, 21.0},
                         {1.0, 21.0, 21.0},
                         {1.5, 20.0, 21.0},
                         {20.0, 1.0, 21.0},
                         {1.0, 1e300, 21.0},
                         {0.0, 20.0, 21.0}})
    check_error([&] { std::apply(labchart, at); }, Code::file_damaged, "lab.mat");
  MatVariable scale = numbers("scaleunits", 1, 1), offset = numbers("scaleoffset", 1, 1);
  MatVariable begin = numbers("datastart", 1, 1), end = numbers("dataend", 1, 1);
  scale.values = {0.5}, offset.values = {2.0}, begin.values = {1.0}, end.values = {40.0};
  CHECK(make_columns({numbers("data", 1, 40), begin, end, scale, offset}, "f").columns[0].values[3] == 2.5);
  check_error(
      [&] {
        make_columns({numbers("data", 1, 40), begin, numbers("dataend", 2, 1)}, "lab.mat");
      },
      Code::file_damaged, "lab.mat");
}
