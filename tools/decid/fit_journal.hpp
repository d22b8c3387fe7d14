// The journal of a fit of many recordings, beside its output: what is done, so that a later call can go on after a
// kill. Form: a line of JSON that says of which call it is, then one for each recording. A line that is cut off or
// damaged, and what follows it, counts as not written.
#pragma once

#include <map>
#include <string>

#include "base/files/disk_file.hpp"
#include "base/files/json_object.hpp"
#include "identify/recordings.hpp"

namespace decid::tools {

class FitJournal {
 public:
  /// settings: what must be the same for its results to be those of this call. resume: keeps what is there; else it
  /// begins empty. Throws Error if another process writes it, or if it is of other settings.
  FitJournal(const std::filesystem::path& path, const Json& settings, bool resume);

  /// The recording's name and its file's content; empty if that cannot be read.
  static std::string key(const RecordingSource& recording);
  /// Null if it is not there.
  const Json* find(const std::string& key) const;
  /// On the disk when it returns.
  void append(const std::string& key, const Json& result);
  void remove();

 private:
  void read(const Json& settings);
  void write_line(const Json& line);

  DiskFile file_;
  std::uint64_t end_ = 0;
  std::map<std::string, Json> results_;
};

}  // namespace decid::tools
