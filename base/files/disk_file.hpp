// A file that is read and written at positions, for data that are too large for memory or grow over a long run. POSIX:
// pread, pwritev, ftruncate, fsync, flock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace decid {

/// A file on disk. All functions throw Error if the system refuses. Many threads may read at once.
class DiskFile {
 public:
  enum class Access {
    read,   ///< an existing file
    write,  ///< read and write; creates a missing file
  };
  DiskFile(std::filesystem::path path, Access access);
  ~DiskFile();
  DiskFile(DiskFile&& other) noexcept;
  DiskFile(const DiskFile&) = delete;
  DiskFile& operator=(const DiskFile&) = delete;

  const std::filesystem::path& path() const noexcept { return path_; }
  std::uint64_t size() const;

  /// Reads bytes. Returns their number, which is smaller than requested only at the end of the file.
  std::size_t read(std::uint64_t position, std::span<std::byte> bytes) const;
  void write(std::uint64_t position, std::span<const std::byte> bytes);
  void write(std::uint64_t position, std::string_view bytes) { write(position, std::as_bytes(std::span(bytes))); }
  /// Writes the pieces in order.
  void write(std::uint64_t position, std::span<const std::span<const std::byte>> pieces);
  void truncate(std::uint64_t size);

  /// Asks the system to start writing these bytes to the disk, without waiting: a later sync() has less to do.
  void start_writeback(std::uint64_t position, std::uint64_t bytes) noexcept;
  /// Waits until all data are on the disk.
  void sync();
  /// Locks the file. Returns false if another process has locked it. The lock lasts until the file is closed, also by a
  /// kill.
  bool try_lock();
  /// Returns false if the path now refers to another file, or none. Throws Error if the system cannot tell.
  bool is_still_at_its_path() const;

 private:
  std::filesystem::path path_;
  int descriptor_;
};

}  // namespace decid
