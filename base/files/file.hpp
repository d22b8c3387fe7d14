// Files that are written completely or not at all: an output is written next to its target and renamed when complete.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace decid {

/// The size limit of files that decid writes itself: models, networks, checkpoints.
inline constexpr std::uint64_t max_own_file_bytes = std::uint64_t{1} << 36;

/// Throws Error for a path with a zero byte, where the system would cut it off. The functions here and DiskFile call
/// it.
void require_path(const std::filesystem::path& path);

/// Returns true if there is a file or folder at a path. Throws Error if the system cannot tell, as for a folder that
/// must not be read.
bool path_exists(const std::filesystem::path& path);

/// Returns the whole file. Throws Error if it cannot be opened or read, or is larger than `limit_bytes`.
std::string read_file(const std::filesystem::path& path, std::uint64_t limit_bytes = std::uint64_t{1} << 32);

/// Replaces `path` by `content` in one step: after a failure or a kill the old file, or none, is there.
void write_file(const std::filesystem::path& path, std::string_view content);

/// A file in preparation by code that needs a path (a library, a long run). Removes its temporary file unless commit()
/// was called.
class PendingFile {
 public:
  /// Throws Error at once if the folder of `target` does not exist or cannot be written.
  explicit PendingFile(std::filesystem::path target);
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  /// Returns the temporary path: in the target's folder, so that the rename is atomic.
  const std::filesystem::path& path() const noexcept { return temporary_; }
  /// Renames the temporary file to the target.
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;
  bool committed_ = false;
};

}  // namespace decid
