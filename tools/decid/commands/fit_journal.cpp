// The journal of a fit: see fit_journal.hpp.
#include "tools/decid/commands/fit_journal.hpp"

#include <filesystem>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/sha256.hpp"
#include "identify/result_archive.hpp"
#include "recording/formats/motion_bids.hpp"

namespace decid::tools {
namespace {

/// A recording's entry.
struct Entry {
  std::string key, result;
  template <class Archive>
  void archive(Archive& a) {
    a(key, result);
  }
};

}  // namespace

FitJournal::FitJournal(const std::filesystem::path& path, const std::string& settings, bool resume)
    : journal_(path, "decid fit journal 6") {
  if (!journal_.try_lock())
    throw Error(Code::file_in_use, path.string(), "is being written by another process", "wait until that has ended");
  if (journal_.is_foreign())
    throw Error(Code::file_unsupported, path.string(), "is not a journal of this decid's fits",
                "delete it, or give another --output");
  if (resume && read(settings)) return;
  journal_.start(settings);
}

bool FitJournal::read(const std::string& settings) {
  const std::optional<std::string> found = journal_.request();
  if (!found) return false;
  if (*found != settings)
    throw Error(Code::file_differs, journal_.path().string(), "was written with other settings",
                "give the options of the call that wrote it, or leave out --resume to start again");
  while (const std::optional<std::string> bytes = journal_.next()) {
    try {
      Entry entry = from_bytes<Entry>(*bytes);
      results_.insert_or_assign(std::move(entry.key), std::move(entry.result));
    } catch (const Error&) {
      journal_.back(bytes->size());
      break;
    }
  }
  return true;
}

std::string FitJournal::key(const RecordingSource& recording, const std::string& settings) {
  try {
    std::string content = recording.name() + '\n' + sha256(read_file(recording.file));
    for (const std::filesystem::path& beside : recording::files_beside(recording.file))
      content += '\n' + beside.string() + '\n' + sha256(read_file(beside));
    return sha256(content + settings);
  } catch (const Error&) {
    return {};  // whoever reads the recording reports it
  }
}

std::optional<RecordingResult> FitJournal::find(const std::string& key) const {
  const auto found = results_.find(key);
  if (key.empty() || found == results_.end()) return std::nullopt;  // no other call has the standard input of this one
  try {
    return from_bytes<RecordingResult>(found->second);
  } catch (const Error&) {
    return std::nullopt;
  }
}

void FitJournal::append(const std::string& key, const RecordingResult& result) {
  journal_.append(to_bytes(Entry{key, to_bytes(result)}));
  journal_.sync();
}

void FitJournal::remove() {
  std::error_code ignored;
  std::filesystem::remove(journal_.path(), ignored);
}

}  // namespace decid::tools
