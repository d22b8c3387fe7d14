// The journal of a fit of many recordings, beside its output: what is done, so that a later call can go on after a
// kill. Form: "decid fit journal 2\n", then entries of a length, the SHA-256 of the text, and the text; the first says
// of which call it is, each other has a recording. An entry that is cut off or damaged, and what follows it, counts as
// not written.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "base/files/disk_file.hpp"
#include "identify/recordings.hpp"

namespace decid::tools {

class FitJournal {
 public:
  /// settings: what must be the same for its results to be those of this call. resume: keeps what is there; else it
  /// begins empty. Throws Error if another process writes it, or if it is of other settings.
  FitJournal(const std::filesystem::path& path, const std::string& settings, bool resume);

  /// Returns a hash of the recording's name and its file's content; empty if that cannot be read.
  static std::string key(const RecordingSource& recording);
  /// Returns nothing if it is not there.
  std::optional<RecordingResult> find(const std::string& key) const;
  /// On the disk when it returns.
  void append(const std::string& key, const RecordingResult& result);
  void remove();

 private:
  void read(const std::string& settings);
  void write_entry(const std::string& text);

  DiskFile file_;
  std::uint64_t end_ = 0;
  std::map<std::string, std::string> results_;  // as bytes
};

}  // namespace decid::tools
