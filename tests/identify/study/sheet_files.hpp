// Sheets and recordings of a study as files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "identify/study/recording_plan.hpp"
#include "identify/study/sheet.hpp"
#include "tests/helpers.hpp"

namespace decid::test {

/// The sources of files, each with another content.
inline std::vector<RecordingSource> sources(const TemporaryFolder& folder, const std::vector<std::string>& names) {
  std::vector<RecordingSource> all;
  for (const std::string& name : names) {
    std::filesystem::create_directories((folder / name).parent_path());
    all.emplace_back(write_text(folder / name, name));
  }
  return all;
}

/// Checks an error that a line or a recording has: its code, and a fact in its text.
inline void check_has(const std::optional<Error>& error, Code code, const std::string& fact,
                      const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  REQUIRE_MESSAGE(error, "called in " << file << ", line " << line);
  check_error([&] { throw *error; }, code, fact, file, line);
}

inline RecordingPlan plan_of_text(const TemporaryFolder& folder, const std::string& sheet,
                                  const std::vector<std::string>& names, Choice choice) {
  const std::filesystem::path path = write_text(folder / "participants.tsv", sheet);
  return make_plan(read_sheet(path), sources(folder, names), choice, {});
}

}  // namespace decid::test
