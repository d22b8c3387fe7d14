// Sheets and recordings of a study as files.
#pragma once

#include <filesystem>
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

inline RecordingPlan plan_of_text(const TemporaryFolder& folder, const std::string& sheet,
                                  const std::vector<std::string>& names, Choice choice) {
  const std::filesystem::path path = write_text(folder / "participants.tsv", sheet);
  return make_plan(read_sheet(path), sources(folder, names), choice, {});
}

}  // namespace decid::test
