// MAT-files of every version: those beside make.py, written by SciPy, and version 7.3, which matio writes here. And
// damaged ones.
#include <matio.h>

#include <cmath>

#include "dataset/recording/recording.hpp"
#include "sim/protocol.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::dataset;
using namespace decid::test;

namespace {

std::filesystem::path made(const char* name) {
  return std::filesystem::path(DECID_SOURCE_DIR) / "tests/dataset/recording/mat" / name;
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
                {name, "is an HDF5 file", "as CSV"});
}

TEST_CASE("fields of structs are columns, and a scalar fs is the rate") {
  check_error(reading(made("v7_struct.mat")),
              {"several columns", "'trial.signals.COM_x'", "'other.COM_x'", "--column"});
  check_made(read_recording(made("v7_struct.mat"), {.column = "trial.signals.COM_x"}));
  check_made(read_recording(made("v7_struct.mat"), {.column = "other.COM_x"}), 2.0);
  check_made(read_recording(made("v7_struct.mat"), {.column = "tilt"}), -2.0);
}

TEST_CASE("a matrix has its columns by number, its times are seen") {
  check_made(read_recording(made("matrix.mat"), {.column = "2"}));
  CHECK(read_recording(made("matrix.mat"), {.column = "2"}).signals.at(com_sway).column == "data(:,2)");
  check_error(reading(made("matrix.mat")), {"'data(:,2)', 'data(:,3)'", "--column"});
  check_made(read_recording(made("wide.mat"), {.column = "1"}));  // a signal a row
  check_made(read_recording(made("wide.mat"), {.column = "data(2,:)"}), -2.0);
}

TEST_CASE("NaN in a MAT-file is a gap, and has a place") {
  check_error(reading(made("gaps.mat")), {"gaps.mat", "row 7, sway", "NaN", "--fill-gaps"});
  check_made(read_recording(made("gaps.mat"), {.fill_gaps_s = 0.02}));
}

TEST_CASE("a MAT-file of version 7.3") {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "v73.mat";
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT73);
  REQUIRE(file != nullptr);
  std::vector<double> time, sway;
  for (int k = 0; k < 20; ++k) {
    time.push_back(k / 50.0);
    sway.push_back((k + 1) / 8.0);
  }
  std::size_t size[] = {20, 1};
  for (const auto& [name, values] : {std::pair{"time", &time}, std::pair{"COM_x", &sway}}) {
    matvar_t* variable = Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size, values->data(), 0);
    REQUIRE(Mat_VarWrite(file, variable, MAT_COMPRESSION_NONE) == 0);
    Mat_VarFree(variable);
  }
  Mat_Close(file);
  REQUIRE(read_text(path).starts_with("MATLAB 7.3"));
  check_made(read_recording(path, {}));
}

TEST_CASE("files without numbers, damaged ones and those that are none are refused") {
  const TemporaryFolder folder;
  check_error(reading(folder / "absent.mat"), {"absent.mat"});
  check_error(reading(made("nothing.mat")), {"no vector or matrix of numbers", "note (1 x 6 text)", "complex"});
  check_error(reading(write_text(folder / "csv.mat", "time,sway\n0,1\n0.01,2\n")), {"csv.mat", "not a MAT-file"});
  check_error(reading(write_text(folder / "empty.mat", "")), {"empty.mat"});
  // 4 GB by the tag of what is compressed, of which nothing is there.
  const std::string deflated("\170\234\343\143\140\140\370\017\004\000\012\156\004\013",
                             14);  // 14, 0, 0, 0, 255, 255, 255, 255
  const std::string tag{15, 0, 0, 0, static_cast<char>(deflated.size()), 0, 0, 0};
  check_error(reading(write_text(folder / "bomb.mat", read_text(made("v5.mat")).substr(0, 128) + tag + deflated)),
              {"bomb.mat", "far too large, inflated"});
  // A name of 2 KB, in version 4.
  std::string named(20, '\0');
  named[4] = 2, named[8] = 1, named[17] = 8;
  check_error(reading(write_text(folder / "name.mat", named + std::string(2048 + 16, 'n'))), {"damaged, in a name"});
  // Cut anywhere, or with any byte changed, a file is read or refused; nothing else happens.
  for (const char* name : {"v4.mat", "v5.mat", "v7_struct.mat"}) {
    const std::string bytes = read_text(made(name));
    int refused = 0;
    const auto survives = [&](const std::string& changed) {
      try {
        read_recording(write_text(folder / "x.mat", changed), {.column = "COM_x", .rate_hz = 50.0});
      } catch (const Error&) {
        ++refused;
      }
    };
    for (std::size_t length = 0; length < bytes.size(); length += 3) survives(bytes.substr(0, length));
    CHECK(refused > 30);
    for (std::size_t at = 0; at < bytes.size(); ++at) {
      std::string changed = bytes;
      changed[at] = static_cast<char>(changed[at] ^ 0x15);
      survives(changed);
    }
  }
}
