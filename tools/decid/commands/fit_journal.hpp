// The journal (base/files/journal.hpp) of a fit of many recordings, in a file next to the output. It holds the results
// so far, so that a later call can resume after a kill.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "base/files/journal.hpp"
#include "identify/recordings.hpp"

namespace decid::tools {

class FitJournal {
 public:
  /// Opens the journal. settings: the settings that its results must share with this call. resume: keeps the existing
  /// results; otherwise the journal begins empty. Throws Error if another process writes it, if it is another
  /// file, or if it has other settings.
  FitJournal(const std::filesystem::path& path, const std::string& settings, bool resume);

  /// Returns a hash of the recording's name, its file's content, the files beside it (BIDS' channels and rate) and its
  /// own settings; empty if a file cannot be read.
  static std::string key(const RecordingSource& recording, const std::string& settings = {});
  /// Returns nothing if the journal does not have this recording.
  std::optional<RecordingResult> find(const std::string& key) const;
  /// Adds a result. The result is on the disk when the function returns.
  void append(const std::string& key, const RecordingResult& result);
  void remove();

 private:
  /// Returns false if the journal has not begun.
  bool read(const std::string& settings);

  Journal journal_;
  std::map<std::string, std::string> results_;  // as bytes
};

}  // namespace decid::tools
