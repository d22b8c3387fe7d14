// A file that is read and written at positions: for what is too large for memory or grows over a long run.
// POSIX: pread, pwritev, ftruncate, fsync, flock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace decid {

/// All functions throw Error when the system refuses. Reading is safe from many threads at once.
class DiskFile {
 public:
  enum class Access {
    read,   ///< an existing file
    write,  ///< read and write; an empty file is made if there is none
  };
  DiskFile(std::filesystem::path path, Access access);
  ~DiskFile();
  DiskFile(DiskFile&& other) noexcept;
  DiskFile(const DiskFile&) = delete;
  DiskFile& operator=(const DiskFile&) = delete;

  const std::filesystem::path& path() const noexcept { return path_; }
  std::uint64_t size() const;

  /// Returns how many bytes there were, less than asked for only at the end of the file.
  std::size_t read(std::uint64_t position, std::span<std::byte> bytes) const;
  void write(std::uint64_t position, std::span<const std::byte> bytes);
  void write(std::uint64_t position, std::string_view bytes) { write(position, std::as_bytes(std::span(bytes))); }
  /// The pieces one after the other.
  void write(std::uint64_t position, std::span<const std::span<const std::byte>> pieces);
  void truncate(std::uint64_t size);

  /// Asks the system to begin writing these bytes to the disk, without waiting: a later sync() has less to do.
  void start_writeback(std::uint64_t position, std::uint64_t bytes) noexcept;
  /// Waits until everything is on the disk.
  void sync();
  /// False if another process holds it. Held until the file is closed, by a kill too.
  bool try_lock();
  /// False if the name now stands for another file, or none. Throws Error if the system does not tell.
  bool is_still_at_its_path() const;

 private:
  std::filesystem::path path_;
  int descriptor_;
};

}  // namespace decid
