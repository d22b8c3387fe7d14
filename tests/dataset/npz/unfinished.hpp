// A data set that is stopped while it is made into its file, and goes on.
#pragma once

#include <filesystem>
#include <string>

#include "base/files/sha256.hpp"
#include "dataset/npz/npz.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/tiny_protocol.hpp"

namespace decid::test {

inline constexpr const char* program = "decid test";

/// Two chunks of base trials and one of children at least.
inline dataset::DatasetRequest request() {
  dataset::DatasetRequest wanted{tiny_protocol(), 1300, 1150, 3};
  wanted.protocol.noise.sensor = {0.001, 0.1};
  return wanted;
}

inline std::string hash_values(const std::filesystem::path& path) {
  return sha256(read_text(path));
}

inline const std::string& expected_hash() {
  static const std::string hash = [] {
    const TemporaryFolder folder;
    dataset::write_npz(folder / "a.npz", dataset::generate(request()));
    return hash_values(folder / "a.npz");
  }();
  return hash;
}

/// State on disk after a run was stopped at a given number of progress reports.
struct Stopped {
  TemporaryFolder folder;
  std::filesystem::path path = folder / "a.npz";
  dataset::NpzPartial partial = dataset::npz_partial(path);
  int trials = 0;

  explicit Stopped(int reports) {
    check_error(
        [&] {
          dataset::generate_npz(path, request(), program, [&](int done, int) {
            trials = done;
            return --reports > 0;
          });
        },
        Code::stopped, "1300 trials");
    CHECK_FALSE(std::filesystem::exists(path));
    CHECK(folder.files() == 2);
  }
};

/// Goes on and checks the bytes; returns where it went on, 0 if from the start.
inline int go_on(const std::filesystem::path& path) {
  int resumed = 0, first = -1;
  dataset::generate_npz(
      path, request(), program,
      [&](int done, int) {
        if (first < 0) first = done;
        return true;
      },
      [&](int trials) { resumed = trials; });
  CHECK(hash_values(path) == expected_hash());
  CHECK_FALSE(std::filesystem::exists(dataset::npz_partial(path).file));
  CHECK_FALSE(std::filesystem::exists(dataset::npz_partial(path).journal));
  return resumed;
}

}  // namespace decid::test
