// The journal of unfinished work, from which a later process continues after a kill or a power failure. Form: a line
// with the journal's name, then entries: length (64 bits), SHA-256 of the bytes in hexadecimal digits, the bytes. The
// first entry is a text that identifies the work. Numbers are little endian. A truncated or damaged entry, and all
// entries after it, count as not written.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/files/disk_file.hpp"

namespace decid {

class Journal {
 public:
  /// Opens the file, and creates a missing one. name: the first line, with the version of the entries' form.
  Journal(const std::filesystem::path& path, std::string_view name);

  const std::filesystem::path& path() const noexcept { return file_.path(); }
  /// Returns false if another process has locked it.
  bool try_lock() { return file_.try_lock(); }

  /// Returns true if the file begins neither with the journal's name nor, truncated, as the name does: start() would
  /// destroy another file.
  bool is_foreign() const;
  /// Returns the text given to start(), or nothing if it is incomplete. Leaves the position at the first entry.
  std::optional<std::string> request();
  /// Empties the journal and begins it; afterwards the text is on the disk.
  void start(std::string_view request);

  /// Returns the entry at the position, if it is complete, and moves the position behind it.
  std::optional<std::string> next();
  /// Moves the position back to the beginning of an entry of this size, which next() has returned.
  void back(std::size_t size) { position_ -= front_size + size; }
  /// Writes an entry at the position, drops everything after it, and moves behind it.
  void append(std::string_view bytes);
  /// Waits until all entries are on the disk.
  void sync() { file_.sync(); }

 private:
  static constexpr std::size_t hash_size = 64, front_size = sizeof(std::uint64_t) + hash_size;

  DiskFile file_;
  std::string name_;  // with its line break
  std::uint64_t position_ = 0;
};

}  // namespace decid
