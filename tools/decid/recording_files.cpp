// Files, folders and patterns: see recording_files.hpp. Patterns: POSIX glob(3).
#include "tools/decid/recording_files.hpp"

#include <glob.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "base/error.hpp"

namespace decid::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 9> endings{".csv", ".tsv",  ".txt", ".dat", ".mat",
                                                  ".c3d", ".xlsx", ".trc", ".mot"};

bool looks_like_a_recording(const fs::path& path) {
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; });
  return !path.filename().native().starts_with('.') && std::ranges::find(endings, ending) != endings.end();
}

/// In the order of their names.
std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    if (entry->is_regular_file(ignored) && looks_like_a_recording(entry->path())) found.push_back(entry->path());
  }
  if (error) throw Error(folder, "cannot be read: " + error.message(), "check the permissions of the folder");
  std::ranges::sort(found);
  return found;
}

/// In order; nothing if there is none.
std::vector<std::string> matches_of(const std::string& pattern) {
  glob_t result{};
  std::vector<std::string> found;
  if (::glob(pattern.c_str(), 0, nullptr, &result) == 0)
    found.assign(result.gl_pathv, result.gl_pathv + result.gl_pathc);
  ::globfree(&result);
  return found;
}

/// What a pattern stands for.
std::vector<std::string> files_like(const std::string& argument) {
  std::error_code ignored;
  std::vector<std::string> found;
  for (const std::string& match : matches_of(argument)) {
    if (!fs::is_directory(match, ignored)) {
      found.push_back(match);
      continue;
    }
    const std::vector<std::string> within = files_in(match);
    found.insert(found.end(), within.begin(), within.end());
  }
  return found;
}

}  // namespace

std::vector<std::string> recording_files(const std::vector<std::string>& arguments,
                                         const std::vector<std::string>& others) {
  std::vector<fs::path> left_out;
  for (const std::string& other : others)
    if (!other.empty()) left_out.push_back(fs::weakly_canonical(other));
  const auto is_left_out = [&](const std::string& file) {
    return std::ranges::find(left_out, fs::weakly_canonical(file)) != left_out.end();
  };
  std::vector<std::string> files;
  for (const std::string& argument : arguments) {
    std::error_code ignored;
    const bool folder = fs::is_directory(argument, ignored);
    const bool pattern = argument.find_first_of("*?[") != std::string::npos && !fs::exists(argument, ignored);
    if (!folder && !pattern) {
      files.push_back(argument);
      continue;
    }
    std::vector<std::string> found = folder ? files_in(argument) : files_like(argument);
    std::erase_if(found, is_left_out);
    if (found.empty() && folder)
      throw Error(argument, "is a folder without a recording",
                  "name one with files that end in .csv, .tsv, .txt, .dat, .mat, .c3d, .xlsx, .trc or .mot, or the "
                  "files themselves");
    if (found.empty()) throw Error(argument, "matches no file", "check the folder and the pattern");
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

}  // namespace decid::tools
