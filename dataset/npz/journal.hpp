// The journal of a data set being made: which trials of it are in the unfinished file, with checksums, so that a later
// run can go on after a kill or a power failure. Private to generate_npz.
// Form: "decid journal 1\n", length and CRC-32 of the request's text, the text; then an entry for each chunk of
// trials, with a CRC-32 of its own. Numbers are little endian. What is cut off or damaged counts as not written.
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
  /// parameters: of a trial.
  Journal(const std::filesystem::path& path, std::size_t parameters)
      : file_(path, DiskFile::Access::write), parameters_(parameters) {}

  /// The text given to start(), or nothing if it is not there whole. Leaves the position at the first entry.
  std::optional<std::string> request();
  /// Empties the journal and begins it; the text is on the disk afterwards.
  void start(const std::string& request);

  /// The entry at the position, if there is a whole one that continues after `trials` trials.
  std::optional<JournalEntry> read(int trials) const;
  /// Moves the position behind the entry that was read.
  void pass(const JournalEntry& entry);
  /// Writes at the position, drops what was behind it, and moves behind it.
  void append(const JournalEntry& entry, int trials_before);

 private:
  std::size_t trial_bytes() const;
  /// Of an entry.
  std::uint64_t bytes_of(std::size_t trials) const;

  DiskFile file_;
  std::size_t parameters_;
  std::uint64_t position_ = 0;
};

}  // namespace decid::dataset
