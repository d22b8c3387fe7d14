// Files, folders and patterns: see recording_files.hpp. Patterns: POSIX glob(3) and fnmatch(3); "**" as in bash.
#include "tools/decid/recording_files.hpp"

#include <fnmatch.h>
#include <glob.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <utility>

#include "base/error.hpp"
#include "base/text.hpp"
#include "identify/study/find_recordings.hpp"
#include "tools/decid/command.hpp"

namespace decid::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view wildcards = "*?[", any_folders = "**";

using Part = fs::path::const_iterator;

/// Returns true if the parts of a path match those of a pattern.
bool matches(Part pattern, Part pattern_end, Part path, Part path_end) {
  for (; pattern != pattern_end; ++pattern, ++path) {
    if (pattern->native() == any_folders) {
      const Part rest = std::next(pattern);
      if (rest == pattern_end) return true;
      for (Part from = path; from != path_end; ++from)
        if (matches(rest, pattern_end, from, path_end)) return true;
      return false;
    }
    if (path == path_end || ::fnmatch(pattern->c_str(), path->c_str(), FNM_PERIOD) != 0) return false;
  }
  return path == path_end;
}

bool has_any_folders(const fs::path& pattern) {
  return std::ranges::find(pattern, fs::path(any_folders)) != pattern.end();
}

/// Returns the matches in order; nothing if there is none.
std::vector<std::string> matches_of(const std::string& pattern) {
  glob_t result{};
  std::vector<std::string> found;
  if (::glob(pattern.c_str(), 0, nullptr, &result) == 0)
    found.assign(result.gl_pathv, result.gl_pathv + result.gl_pathc);
  ::globfree(&result);
  return found;
}

/// Looks for recordings in folders, and counts what it leaves out.
class Search {
 public:
  /// Creates the search. `used`: files that the call reads or writes for other purposes.
  Search(bool recursive, std::vector<fs::path> used) : recursive_(recursive), used_(std::move(used)) {}

  /// Returns the files of a folder in the order of their names.
  std::vector<std::string> files_in(const std::string& folder) {
    std::vector<std::string> found;
    visit_files(folder, recursive_, [&](const fs::path& path) {
      if (is_recording(path, false)) found.push_back(path);
    });
    std::ranges::sort(found);
    return found;
  }

  std::vector<std::string> files_like(const std::string& pattern) {
    if (has_any_folders(pattern)) return files_beneath(pattern);
    std::error_code ignored;
    std::vector<std::string> found;
    for (const std::string& match : matches_of(pattern)) {
      if (!fs::is_directory(match, ignored)) {
        if (is_recording(match, true)) found.push_back(match);
        continue;
      }
      const std::vector<std::string> within = files_in(match);
      found.insert(found.end(), within.begin(), within.end());
    }
    return found;
  }

  const LeftOut& left_out() const { return left_out_; }

 private:
  /// Returns true for a file that may be a recording; counts others. `any_ending`: the pattern names the ending.
  bool is_recording(const fs::path& path, bool any_ending) {
    std::error_code ignored;
    if (is_hidden(path) || std::ranges::find(used_, locate(path)) != used_.end()) return false;
    if (!fs::is_regular_file(path, ignored)) {
      left_out_.dead_links += fs::is_symlink(path, ignored) && !fs::exists(path, ignored) ? 1 : 0;
      return false;
    }
    if (is_description(path)) {
      ++left_out_.descriptions;
      return false;
    }
    if (is_table_of_results(path)) {
      ++left_out_.results;
      return false;
    }
    if (any_ending || has_ending_of_recordings(path)) return true;
    ++left_out_.other_endings;
    left_out_.endings.insert(path.has_extension() ? path.extension().string() : path.filename().string());
    return false;
  }

  /// Calls visit(path) for all that the folder holds except folders, and, if asked for, for all that folders within
  /// hold. Passes over hidden folders.
  template <class Visit>
  void visit_files(const std::string& folder, bool recursive, const Visit& visit) {
    std::error_code error;
    for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
      std::error_code ignored;
      if (!entry->is_directory(ignored)) {
        visit(entry->path());
        continue;
      }
      const bool hidden = is_hidden(entry->path());
      if (!hidden && !recursive) ++left_out_.folders;
      if (hidden || !recursive) entry.disable_recursion_pending();
    }
    if (error)
      throw Error(Code::file_unreadable, folder, "cannot be read: " + error.message(),
                  "check the permissions of the folder");
  }

  /// Returns the files that match a pattern with "**".
  std::vector<std::string> files_beneath(const fs::path& pattern) {
    fs::path folder;
    for (const fs::path& part : pattern) {
      if (part.native().find_first_of(wildcards) != std::string::npos) break;
      folder /= part;
    }
    const fs::path whole = folder.empty() ? "." / pattern : pattern;
    if (folder.empty()) folder = ".";
    std::error_code ignored;
    if (!fs::is_directory(folder, ignored)) return {};
    const bool any_ending = std::prev(whole.end())->native() != any_folders;
    std::vector<std::string> found;
    visit_files(folder, true, [&](const fs::path& path) {
      if (matches(whole.begin(), whole.end(), path.begin(), path.end()) && is_recording(path, any_ending))
        found.push_back(path);
    });
    std::ranges::sort(found);
    return found;
  }

  bool recursive_;
  std::vector<fs::path> used_;
  LeftOut left_out_;
};

}  // namespace

std::string LeftOut::text() const {
  std::vector<std::string> parts;
  const auto add = [&](std::size_t count, const std::string& what, const std::string& more) {
    if (count > 0) parts.push_back(counted(static_cast<long long>(count), what) + more);
  };
  add(dead_links, "dead link", "");
  add(other_endings, "file", " of other kinds (" + joined(endings, ", ") + ")");
  add(descriptions, "description", " (participants.tsv, README and the like)");
  add(results, "table", " of decid's results");
  add(folders, "folder", " within (--recursive reads them)");
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "left out: " : ", ") + part;
  return text;
}

RecordingFiles recording_files(const std::vector<std::string>& arguments, const std::vector<std::string>& others,
                               bool recursive) {
  if (std::ranges::count(arguments, "-") > 1)
    throw Error(Code::setting_conflict, "-", "standard input is named twice, and can be read only once",
                "name it once");
  std::vector<fs::path> used;
  for (const std::string& other : others)
    if (!other.empty()) used.push_back(locate(other));
  Search search(recursive, std::move(used));
  std::vector<std::string> files;
  for (const std::string& argument : arguments) {
    std::error_code ignored;
    const bool folder = fs::is_directory(argument, ignored);
    const bool pattern = argument.find_first_of(wildcards) != std::string::npos && !fs::exists(argument, ignored);
    if (!folder && !pattern) {
      files.push_back(argument);
      continue;
    }
    const std::vector<std::string> found = folder ? search.files_in(argument) : search.files_like(argument);
    const std::string left_out = search.left_out().text();
    const std::string more = left_out.empty() ? "" : " (" + left_out + ")";
    if (found.empty() && folder)
      throw Error(
          Code::file_missing, argument, "is a folder without a recording" + more,
          "name one with files that end in .csv, .tsv, .txt, .dat, .mat, .c3d, .xlsx, .trc, .mot, .sto or .lvm, or the "
          "files themselves");
    if (found.empty())
      throw Error(Code::file_missing, argument, "matches no file" + more, "check the folder and the pattern");
    files.insert(files.end(), found.begin(), found.end());
  }
  return {std::move(files), search.left_out()};
}

}  // namespace decid::tools
