// Reads and writes at positions: see disk_file.hpp. The system may return short counts or be interrupted by signals;
// every loop here continues after either.
#include "base/files/disk_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/text.hpp"

namespace decid {
namespace {

[[noreturn]] void fail_at_position(const std::filesystem::path& path, int error) {
  throw WriteError(path.string(), "cannot be written: " + errno_text(error),
                   error == ENOSPC || error == EDQUOT
                       ? "free space on its disk and run the same command again"
                       : "check the disk and its mount, then run the same command again");
}

std::filesystem::path required(std::filesystem::path path) {
  require_path(path);
  return path;
}

}  // namespace

DiskFile::DiskFile(std::filesystem::path path, Access access)
    : path_(required(std::move(path))),
      descriptor_(::open(path_.c_str(), (access == Access::read ? O_RDONLY : O_RDWR | O_CREAT) | O_CLOEXEC, 0666)) {
  if (descriptor_ >= 0) return;
  const int error = errno;
  if (access == Access::read) {
    throw Error(opening_failed(error), path_.string(), "cannot be opened: " + errno_text(error),
                "check the name and the permissions of the file");
  }
  const std::filesystem::path folder = path_.parent_path().empty() ? "." : path_.parent_path();
  std::error_code ignored;
  if (error == ENOENT && !std::filesystem::exists(folder, ignored)) {
    throw Error(Code::file_unwritable, path_.string(), "its folder does not exist",
                "create the folder " + folder.string() + " first");
  }
  if (error == ENOSPC || error == EDQUOT) fail_at_position(path_, error);
  throw Error(Code::file_unwritable, path_.string(), "cannot be created: " + errno_text(error),
              "choose a folder that exists and that you may write to");
}

DiskFile::~DiskFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

DiskFile::DiskFile(DiskFile&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

std::uint64_t DiskFile::size() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) {
    throw Error(Code::file_unreadable, path_.string(), "its size cannot be read: " + errno_text(errno),
                "check the disk and its mount");
  }
  return static_cast<std::uint64_t>(status.st_size);
}

std::size_t DiskFile::read(std::uint64_t position, std::span<std::byte> bytes) const {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count =
        ::pread(descriptor_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(position + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0)
      throw Error(Code::file_unreadable, path_.string(), "reading failed: " + errno_text(errno),
                  "check the disk and its mount");
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  return done;
}

void DiskFile::write(std::uint64_t position, std::span<const std::byte> bytes) {
  write(position, std::span<const std::span<const std::byte>>(&bytes, 1));
}

void DiskFile::write(std::uint64_t position, std::span<const std::span<const std::byte>> pieces) {
  constexpr std::size_t max_pieces = 256;  // pieces per call; Linux allows 1024
  std::size_t next = 0, done_of_next = 0;
  std::vector<iovec> vectors;
  while (next < pieces.size()) {
    vectors.clear();
    for (std::size_t i = next; i < std::min(next + max_pieces, pieces.size()); ++i) {
      const auto piece = i == next ? pieces[i].subspan(done_of_next) : pieces[i];
      // The system only reads them, but its structure also serves for reading into them.
      vectors.push_back({const_cast<std::byte*>(piece.data()), piece.size()});
    }
    const ssize_t count =
        ::pwritev(descriptor_, vectors.data(), static_cast<int>(vectors.size()), static_cast<off_t>(position));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail_at_position(path_, errno);
    position += static_cast<std::uint64_t>(count);
    auto left = static_cast<std::size_t>(count);
    for (; next < pieces.size() && left >= pieces[next].size() - done_of_next; ++next) {
      left -= pieces[next].size() - done_of_next;
      done_of_next = 0;
    }
    done_of_next += left;
  }
}

void DiskFile::truncate(std::uint64_t size) {
  while (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) {
    if (errno != EINTR) fail_at_position(path_, errno);
  }
}

void DiskFile::start_writeback([[maybe_unused]] std::uint64_t position, [[maybe_unused]] std::uint64_t bytes) noexcept {
#ifdef __linux__
  static_cast<void>(
      ::sync_file_range(descriptor_, static_cast<off_t>(position), static_cast<off_t>(bytes), SYNC_FILE_RANGE_WRITE));
#endif
}

void DiskFile::sync() {
  while (::fsync(descriptor_) != 0) {
    if (errno != EINTR) fail_at_position(path_, errno);
  }
}

bool DiskFile::try_lock() {
  while (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) return false;
    if (errno != EINTR) break;  // a file system without locks: two runs at once are the user's responsibility
  }
  return true;
}

bool DiskFile::is_still_at_its_path() const {
  struct stat open {
  }, named{};
  if (::fstat(descriptor_, &open) != 0) fail_at_position(path_, errno);
  return ::stat(path_.c_str(), &named) == 0 && open.st_dev == named.st_dev && open.st_ino == named.st_ino;
}

}  // namespace decid
