// Copies among recordings: see contradictions.hpp.
#include <filesystem>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/sha256.hpp"
#include "base/parallel.hpp"
#include "identify/study/detail/contradictions.hpp"

namespace decid {
namespace {

namespace fs = std::filesystem;

/// Returns the files that have the size of another one, or are given twice, with their size.
std::vector<std::pair<fs::path, std::size_t>> files_of_equal_size(const RecordingPlan& plan) {
  std::map<std::uintmax_t, std::map<fs::path, std::size_t>> by_size;  // the number of each file's recordings
  for (const PlannedRecording& planned : plan.recordings) {
    std::error_code failed;
    if (planned.error || !fs::is_regular_file(planned.source.file, failed)) continue;
    if (const std::uintmax_t bytes = fs::file_size(planned.source.file, failed); !failed)
      ++by_size[bytes][planned.source.file];
  }
  std::vector<std::pair<fs::path, std::size_t>> files;
  for (const auto& [bytes, some] : by_size)
    if (some.size() > 1 || some.begin()->second > 1) files.insert(files.end(), some.begin(), some.end());
  return files;
}

/// Returns the hash of each file that has the size of another one, or is given twice. A file that cannot be read has
/// none: reading the recording gives its error.
std::map<fs::path, std::string> hash_files(const RecordingPlan& plan) {
  const std::vector<std::pair<fs::path, std::size_t>> files = files_of_equal_size(plan);
  std::vector<std::string> hashes(files.size());
  parallel_for(static_cast<int>(files.size()), [&](int place) {
    const auto i = static_cast<std::size_t>(place);
    try {
      hashes[i] = sha256(read_file(files[i].first));
    } catch (const Error&) {
      hashes[i].clear();
    }
  });
  std::map<fs::path, std::string> all;
  for (std::size_t i = 0; i < files.size(); ++i)
    if (!hashes[i].empty()) all.emplace(files[i].first, hashes[i]);
  return all;
}

}  // namespace

void warn_of_copies(RecordingPlan& plan) {
  const std::map<fs::path, std::string> hashes = hash_files(plan);
  using Options = std::vector<std::pair<std::string, std::string>>;
  std::map<std::tuple<std::string, std::string, std::string, Options>, std::vector<std::size_t>> same;
  for (std::size_t i = 0; i < plan.recordings.size(); ++i) {
    const PlannedRecording& planned = plan.recordings[i];
    const auto hash = hashes.find(planned.source.file);
    if (planned.error || hash == hashes.end()) continue;
    same[{hash->second, planned.source.trial, plan.settings[planned.setting].protocol, planned.options}].push_back(i);
  }
  for (const auto& [content, copies] : same)
    for (std::size_t k = 0; copies.size() > 1 && k < copies.size(); ++k) {
      const std::string other = plan.recordings[copies[k == 0 ? 1 : 0]].source.name();
      Warnings& warnings = plan.recordings[copies[k]].warnings;
      add_caution(warnings, "same_content",
                  "holds the same bytes as " + other +
                      ": a copy is neither another person nor another trial; leave one of them out");
    }
}

}  // namespace decid
