// The journal of an unfinished data set: it lists the trials in the file, with checksums, so that a later run can
// continue after a kill or a power failure. Private to generate_npz. Form: "decid journal 1
// ", length and CRC-32 of the request's text, the text; then an entry for each chunk of trials, with its own CRC-32.
// Numbers are little endian. Truncated or damaged entries count as not written.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/files/disk_file.hpp"
#include "dataset/sets/generator.hpp"

namespace decid::dataset {

struct JournalEntry {
  Chunk chunk;  ///< without its sway
  std::uint32_t sway_crc32 = 0;
};

class Journal {
 public:
  /// parameters: per trial.
  Journal(const std::filesystem::path& path, std::size_t parameters)
      : file_(path, DiskFile::Access::write), parameters_(parameters) {}

  /// Returns the text given to start(), or nothing if it is incomplete. Leaves the position at the first entry.
  std::optional<std::string> request();
  /// Empties the journal and begins it; afterwards the text is on the disk.
  void start(const std::string& request);

  /// Returns the entry at the position, if it is complete and continues after `trials` trials.
  std::optional<JournalEntry> read(int trials) const;
  /// Moves the position after the entry that was read.
  void pass(const JournalEntry& entry);
  /// Writes an entry at the position, drops everything after it, and moves behind it.
  void append(const JournalEntry& entry, int trials_before);

 private:
  std::size_t trial_bytes() const;
  /// Returns the size of an entry.
  std::uint64_t bytes_of(std::size_t trials) const;

  DiskFile file_;
  std::size_t parameters_;
  std::uint64_t position_ = 0;
};

}  // namespace decid::dataset
