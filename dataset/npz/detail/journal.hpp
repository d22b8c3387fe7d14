// The journal (base/files/journal.hpp) of an unfinished data set: it lists the trials in the file, with checksums.
// Private to generate_npz.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/archive.hpp"
#include "base/files/journal.hpp"
#include "dataset/sets/generator.hpp"

namespace decid::dataset {

struct JournalEntry {
  Chunk chunk;  ///< without its sway
  std::uint32_t sway_crc32 = 0;
};

class ChunkJournal {
 public:
  explicit ChunkJournal(const std::filesystem::path& path) : journal_(path, "decid journal 2") {}

  bool is_foreign() const { return journal_.is_foreign(); }
  std::optional<std::string> request() { return journal_.request(); }
  void start(const std::string& request) { journal_.start(request); }

  /// Returns the entry at the position, if it is complete and continues after `trials` trials, and moves behind it.
  std::optional<JournalEntry> next(int trials);
  /// Moves back to the beginning of the last entry that next() returned.
  void back() { journal_.back(last_size_); }
  /// Writes an entry at the position, drops everything after it, and moves behind it.
  void append(const JournalEntry& entry, int trials_before);

 private:
  Journal journal_;
  std::size_t last_size_ = 0;
};

}  // namespace decid::dataset
