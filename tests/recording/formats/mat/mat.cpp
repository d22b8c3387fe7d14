// MAT-files of every version: those beside make.py, written by SciPy, and version 7.3, which matio writes here. And
// damaged ones.
#include <matio.h>

#include <cstdint>
#include <cstring>

#include "recording/formats/detail/mat/mat_73.hpp"
#include "recording/recording.hpp"
#include "sim/protocol/protocol.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

std::filesystem::path made(const char* name) {
  return std::filesystem::path(DECID_SOURCE_DIR) / "tests/recording/mat" / name;
}

/// 1/8, 2/8, ... 20/8 degrees at 50 Hz, times `factor`.
void check_made(const Recording& recording, double factor = 1.0) {
  CHECK(recording.rate_hz == 50.0);
  REQUIRE(recording.signals.at(com_sway).rad.size() == 20);
  for (std::size_t k = 0; k < 20; ++k) {
    CHECK(recording.signals.at(com_sway).rad[k] == factor * static_cast<double>(k + 1) / 8.0 * sim::rad_per_deg);
  }
}

auto reading(const std::filesystem::path& path, const RecordingOptions& options = {}) {
  return [path, options] { read_recording(path, options); };
}

}  // namespace

TEST_CASE("variables of versions 4 and 5 are columns") {
  const Recording recording = read_recording(made("v4.mat"), {.tilt_column = "tilt_deg"});
  CHECK(recording.signals.at(com_sway).column == "COM_x");
  check_made(recording);
  REQUIRE(recording.signals.at(platform_tilt).rad.size() == 20);
  CHECK(recording.signals.at(platform_tilt).rad[19] == -5.0 * sim::rad_per_deg);
  check_made(read_recording(made("v5.mat"), {}));
  check_error(reading(made("v5.mat"), {.skip_lines = 1}), Code::setting_conflict, "skip_lines");
  check_error(reading(made("v5.mat"), {.section = "1"}), Code::setting_conflict);
  check_made(read_recording(made("v5.mat"), {.column = "k"}), 8.0);  // whole numbers
}

TEST_CASE("version 7.3 as h5py writes it, with classes that end without a null or are not named") {
  const Recording recording = read_recording(made("v73_h5py.mat"), {.tilt_column = "tilt_deg"});
  check_made(recording);
  CHECK(recording.signals.at(platform_tilt).rad[19] == -5.0 * sim::rad_per_deg);
  // HDF5 without MATLAB's header is another format.
  const TemporaryFolder folder;
  for (const char* name : {"r.mat", "r.h5"})
    check_error(reading(write_text(folder / name, "\x89HDF\r\n\x1a\n" + std::string(100, '\0'))),
                Code::file_unsupported, "5 file");
}

TEST_CASE("fields of structs are columns, and a scalar fs is the rate") {
  check_error(reading(made("v7_struct.mat")), Code::column_ambiguous, "'trial.signals.COM_x'");
  check_made(read_recording(made("v7_struct.mat"), {.column = "trial.signals.COM_x"}));
  check_made(read_recording(made("v7_struct.mat"), {.column = "other.COM_x"}), 2.0);
  check_made(read_recording(made("v7_struct.mat"), {.column = "tilt"}), -2.0);
}

TEST_CASE("a matrix has its columns by number, its times are seen") {
  check_made(read_recording(made("matrix.mat"), {.column = "2"}));
  CHECK(read_recording(made("matrix.mat"), {.column = "2"}).signals.at(com_sway).column == "data(:,2)");
  check_error(reading(made("matrix.mat")), Code::column_ambiguous, "'data(:,2)', 'data(:,3)'");
  check_made(read_recording(made("wide.mat"), {.column = "1"}));  // a signal a row
  check_made(read_recording(made("wide.mat"), {.column = "data(2,:)"}), -2.0);
}

TEST_CASE("NaN in a MAT-file is a gap, and has a place") {
  check_error(reading(made("gaps.mat")), Code::value_missing, "row 7, sway");
  check_made(read_recording(made("gaps.mat"), {.fill_gaps_s = 0.02}));
}

namespace {

/// A file of version 7.3 by matio.
class Mat73 {
 public:
  explicit Mat73(const std::filesystem::path& path) : file_(Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT73)) {
    REQUIRE(file_ != nullptr);
  }
  ~Mat73() { Mat_Close(file_); }
  Mat73(const Mat73&) = delete;
  Mat73& operator=(const Mat73&) = delete;

  void write(matvar_t* variable) {
    REQUIRE(Mat_VarWrite(file_, variable, MAT_COMPRESSION_NONE) == 0);
    Mat_VarFree(variable);
  }

 private:
  mat_t* file_;
};

/// Writes a file of sway k / 8 degrees, k = 1..20, with times of this unit from November 2024 on.
void write_unix_times(const std::filesystem::path& path, mat_ft version, matio_compression compression, double per_s,
                      bool whole) {
  std::vector<double> time, sway;
  std::vector<std::int64_t> counts;
  for (int k = 0; k < 20; ++k) {
    time.push_back((1732876342.0 + k / 50.0) * per_s);
    counts.push_back(static_cast<std::int64_t>(1732876342.0 * per_s) + static_cast<std::int64_t>(k * per_s / 50.0));
    sway.push_back((k + 1) / 8.0);
  }
  std::size_t size[] = {20, 1};
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, version);
  REQUIRE(file != nullptr);
  for (matvar_t* variable : {whole ? Mat_VarCreate("time", MAT_C_INT64, MAT_T_INT64, 2, size, counts.data(), 0)
                                   : Mat_VarCreate("time", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size, time.data(), 0),
                             Mat_VarCreate("COM_x", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size, sway.data(), 0)}) {
    REQUIRE(Mat_VarWrite(file, variable, compression) == 0);
    Mat_VarFree(variable);
  }
  Mat_Close(file);
}

/// A column: `first`, first + 1, ... as T.
template <class T>
matvar_t* column_of(const char* name, matio_classes kind, matio_types type, int first) {
  std::vector<T> values;
  for (int k = 0; k < 20; ++k) values.push_back(static_cast<T>(first + k));
  std::size_t size[] = {values.size(), 1};
  return Mat_VarCreate(name, kind, type, 2, size, values.data(), 0);
}

template <class T>
void check_class(const std::filesystem::path& path, matio_classes kind, matio_types type, int first) {
  {
    Mat73 file(path);
    file.write(column_of<T>("COM_x", kind, type, first));
  }
  const Recording recording = read_recording(path, {.rate_hz = 50.0});
  REQUIRE(recording.signals.at(com_sway).rad.size() == 20);
  for (int k = 0; k < 20; ++k)
    CHECK(recording.signals.at(com_sway).rad[static_cast<std::size_t>(k)] == (first + k) * sim::rad_per_deg);
}

}  // namespace

TEST_CASE("Unix times are in the unit that their size shows, as in CSV: versions 5, 7 and 7.3") {
  const TemporaryFolder folder;
  for (const double per_s : {1.0, 1e3, 1e6, 1e9}) {
    for (const bool whole : {false, true}) {
      if (whole && per_s == 1.0) continue;
      CAPTURE(per_s);
      CAPTURE(whole);
      const auto check = [&](const char* name, mat_ft version, matio_compression compression) {
        write_unix_times(folder / name, version, compression, per_s, whole);
        check_made(read_recording(folder / name, {}));
      };
      check("v5.mat", MAT_FT_MAT5, MAT_COMPRESSION_NONE);
      check("v7.mat", MAT_FT_MAT5, MAT_COMPRESSION_ZLIB);
      check("v73.mat", MAT_FT_MAT73, MAT_COMPRESSION_NONE);
    }
  }
}

TEST_CASE("version 7.3: numbers of every class") {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "class.mat";
  check_class<double>(path, MAT_C_DOUBLE, MAT_T_DOUBLE, -9);
  CHECK(read_text(path).starts_with("MATLAB 7.3"));
  check_class<float>(path, MAT_C_SINGLE, MAT_T_SINGLE, -9);
  check_class<std::int8_t>(path, MAT_C_INT8, MAT_T_INT8, -9);
  check_class<std::uint8_t>(path, MAT_C_UINT8, MAT_T_UINT8, 0);
  check_class<std::int16_t>(path, MAT_C_INT16, MAT_T_INT16, -9);
  check_class<std::uint16_t>(path, MAT_C_UINT16, MAT_T_UINT16, 0);
  check_class<std::int32_t>(path, MAT_C_INT32, MAT_T_INT32, -9);
  check_class<std::uint32_t>(path, MAT_C_UINT32, MAT_T_UINT32, 0);
  check_class<std::int64_t>(path, MAT_C_INT64, MAT_T_INT64, -9);
  check_class<std::uint64_t>(path, MAT_C_UINT64, MAT_T_UINT64, 0);
}

TEST_CASE("version 7.3: fields of structures are columns; variables without real numbers are named") {
  const TemporaryFolder folder;
  std::size_t one[] = {1, 1}, text[] = {1, 6}, twenty[] = {20, 1};
  const char* fields[] = {"time", "COM_x"};
  {
    Mat73 file(folder / "structure.mat");
    matvar_t* trial = Mat_VarCreateStruct("trial", 2, one, fields, 2);
    std::vector<double> time, sway;
    for (int k = 0; k < 20; ++k) {
      time.push_back(k / 50.0);
      sway.push_back((k + 1) / 8.0);
    }
    Mat_VarSetStructFieldByName(trial, "time", 0,
                                Mat_VarCreate("time", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, twenty, time.data(), 0));
    Mat_VarSetStructFieldByName(trial, "COM_x", 0,
                                Mat_VarCreate("COM_x", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, twenty, sway.data(), 0));
    file.write(trial);
  }
  check_made(read_recording(folder / "structure.mat", {}));
  {
    Mat73 file(folder / "nothing.mat");
    char note[] = "a note";
    file.write(Mat_VarCreate("note", MAT_C_CHAR, MAT_T_UTF8, 2, text, note, 0));
    matvar_t* cell = Mat_VarCreate("cells", MAT_C_CELL, MAT_T_CELL, 2, one, nullptr, 0);
    Mat_VarSetCell(cell, 0, Mat_VarCreate("", MAT_C_CHAR, MAT_T_UTF8, 2, text, note, 0));
    file.write(cell);
    std::vector<double> part(20, 1.0);
    mat_complex_split_t parts{part.data(), part.data()};
    file.write(Mat_VarCreate("z", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, twenty, &parts, MAT_F_COMPLEX));
  }
  check_error(reading(folder / "nothing.mat"), Code::file_empty, "1 x");
}

TEST_CASE("version 7.3: arrays of structures and cells have elements, pages and text are read") {
  const TemporaryFolder folder;
  std::size_t two[] = {1, 2}, twenty[] = {20, 1}, cube[] = {20, 1, 2}, letters[] = {1, 4};
  const char* fields[] = {"time", "COM_x"};
  std::vector<double> time, sway;
  for (int k = 0; k < 40; ++k) {
    time.push_back(k / 50.0);
    sway.push_back(k < 20 ? (k + 1) / 8.0 : (k - 19) / 4.0);
  }
  const auto to_vector = [&](double* from) {
    return Mat_VarCreate("", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, twenty, from, 0);
  };
  {
    Mat73 file(folder / "array.mat");
    matvar_t* trials = Mat_VarCreateStruct("trials", 2, two, fields, 2);
    for (std::size_t i = 0; i < 2; ++i) {
      Mat_VarSetStructFieldByName(trials, "time", i, to_vector(time.data()));
      Mat_VarSetStructFieldByName(trials, "COM_x", i, to_vector(sway.data() + 20 * i));
    }
    file.write(trials);
  }
  for (const auto& [trial, factor] : {std::pair{"1", 1.0}, std::pair{"2", 2.0}})
    check_made(read_recording(folder / "array.mat", {.trial_column = "trials", .trial = trial}), factor);
  check_error(reading(folder / "array.mat"), Code::column_ambiguous, "'trials(1).COM_x', 'trials(2).COM_x'");
  {
    Mat73 file(folder / "cell.mat");
    char name[] = "sway";
    matvar_t* cell = Mat_VarCreate("sway", MAT_C_CELL, MAT_T_CELL, 2, two, nullptr, 0);
    for (int i = 0; i < 2; ++i) Mat_VarSetCell(cell, i, to_vector(sway.data() + 20 * i));
    file.write(cell);
    file.write(Mat_VarCreate("cube", MAT_C_DOUBLE, MAT_T_DOUBLE, 3, cube, sway.data(), 0));
    file.write(Mat_VarCreate("labels", MAT_C_CHAR, MAT_T_UTF8, 2, letters, name, 0));
  }
  check_made(read_recording(folder / "cell.mat", {.column = "sway{2}", .rate_hz = 50.0}), 2.0);
  check_made(read_recording(folder / "cell.mat", {.column = "cube(:,1,2)", .rate_hz = 50.0}), 2.0);
  CHECK(list_trials(folder / "cell.mat", {.trial_column = "sway"}).size() == 2);
}

TEST_CASE("version 7.3: an answer of the process that reads it is taken whole or not at all") {
  const std::vector<MatVariable> variables{
      {.name = "time", .height = 2, .width = 1, .values = {0.0, 0.5}, .text = {"a", "row"}},
      {.name = "trial",
       .kind = MatVariable::Kind::structure,
       .height = 1,
       .width = 1,
       .fields = {{.name = "note", .kind = MatVariable::Kind::text, .is_matrix = false}}}};
  const std::string bytes = to_bytes(variables);
  std::vector<MatVariable> read;
  REQUIRE(from_bytes(bytes, read));
  REQUIRE(read.size() == 2);
  CHECK(read[0].values == variables[0].values);
  CHECK(read[0].text == variables[0].text);
  CHECK(read[1].kind == MatVariable::Kind::structure);
  REQUIRE(read[1].fields.size() == 1);
  CHECK(read[1].fields[0].name == "note");
  CHECK_FALSE(read[1].fields[0].is_matrix);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    read.clear();
    CHECK_FALSE(from_bytes(bytes.substr(0, length), read));
  }
  read.clear();
  CHECK_FALSE(from_bytes(bytes + '\0', read));
  // Places in the bytes of the first variable, behind how many there are, the name's length and the name: 8 each.
  const auto changed = [&](std::size_t place, std::uint64_t to) {
    std::string other = bytes;
    std::memcpy(other.data() + place, &to, sizeof to);
    read.clear();
    return from_bytes(other, read);
  };
  constexpr std::size_t kind = 8 + 8 + 4, is_matrix = kind + 8, height = is_matrix + 8, width = height + 8,
                        pages = width + 8;
  CHECK(changed(kind, 0));
  CHECK_FALSE(changed(kind, 8));
  CHECK_FALSE(changed(is_matrix, 2));
  CHECK_FALSE(changed(height, 3));
  CHECK_FALSE(changed(width, 0));
  CHECK_FALSE(changed(width, 3));
  CHECK_FALSE(changed(pages, 0));
  CHECK_FALSE(changed(pages, 2));
  CHECK_FALSE(changed(0, ~std::uint64_t{0}));
  // Structures within structures, deeper than any that are read.
  MatVariable deep{.name = "d", .kind = MatVariable::Kind::structure, .height = 1, .width = 1};
  for (int depth = 0; depth < deepest_structure + 1; ++depth) {
    MatVariable outer{.name = "d", .kind = MatVariable::Kind::structure, .height = 1, .width = 1};
    outer.fields.push_back(std::move(deep));
    deep = std::move(outer);
  }
  read.clear();
  CHECK_FALSE(from_bytes(to_bytes({deep}), read));
}

TEST_CASE("Octave's own formats are recognised in the error") {
  const TemporaryFolder folder;
  for (const char* text :
       {"# Created by Octave 7.3.0, Wed Nov 25 2026\n# name: sway\n# type: matrix\n# rows: 1\n", "Octave-1-L"})
    for (const char* name : {"a.mat", "a.txt"})
      check_error(reading(write_text(folder / name, text)), Code::file_unsupported, name);
}

TEST_CASE("files without numbers, damaged ones and those that are none are refused") {
  const TemporaryFolder folder;
  check_error(reading(folder / "absent.mat"), Code::file_missing, "absent.mat");
  check_error(reading(made("nothing.mat")), Code::file_empty, "1 x");
  check_error(reading(write_text(folder / "csv.mat", "time,sway\n0,1\n0.01,2\n")), Code::file_damaged, "csv.mat");
  check_error(reading(write_text(folder / "empty.mat", "")), Code::file_damaged, "empty.mat");
  // 4 GB by the tag of what is compressed, of which nothing is there.
  const std::string deflated("\170\234\343\143\140\140\370\017\004\000\012\156\004\013",
                             14);  // 14, 0, 0, 0, 255, 255, 255, 255
  const std::string tag{15, 0, 0, 0, static_cast<char>(deflated.size()), 0, 0, 0};
  check_error(reading(write_text(folder / "bomb.mat", read_text(made("v5.mat")).substr(0, 128) + tag + deflated)),
              Code::file_too_large, "bomb.mat");
  // A name of 2 KB, in version 4.
  std::string named(20, '\0');
  named[4] = 2, named[8] = 1, named[17] = 8;
  check_error(reading(write_text(folder / "name.mat", named + std::string(2048 + 16, 'n'))), Code::file_damaged);
}
