// Writes files completely or not at all: see file.hpp. Method: an exclusively created temporary file in the target's
// folder, fsync, rename(2), fsync of the folder. Devices, pipes and the target of /dev/stdout cannot be replaced; they
// are written directly.
#include "base/files/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/text.hpp"

namespace decid {
namespace {

namespace fs = std::filesystem;

// A file descriptor that is closed at the end of its scope.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  bool is_open() const { return number_ >= 0; }
  int number() const { return number_; }
  /// Closes it. Returns false on an error, which may be the first sign of a failed write.
  bool close() { return ::close(std::exchange(number_, -1)) == 0; }

 private:
  int number_;
};

/// Writes a file's content to the disk. Returns false on an error.
bool sync(int number) {
  while (::fsync(number) != 0) {
    if (errno != EINTR) return false;
  }
  return true;
}

[[noreturn]] void fail_to_write(const fs::path& path, int error) {
  throw WriteError(path.string(), "writing failed: " + errno_text(error),
                   error == ENOSPC || error == EDQUOT ? "free space on its disk, or write to another"
                                                      : "check the disk and its mount");
}

// The target of a path, after following symbolic links.
struct Target {
  fs::path path;
  bool direct;  // true for files that cannot be replaced
};

Target resolve(const fs::path& path) {
  constexpr int max_links = 40;  // the limit of Linux
  fs::path current = path;
  std::error_code error;
  for (int i = 0; i < max_links && fs::is_symlink(current, error); ++i) {
    // A link in /proc (/dev/stdout leads to one) refers to an open file, and its text need not be that file's name.
    const fs::path folder = fs::canonical(current.parent_path().empty() ? "." : current.parent_path(), error);
    if (!error && folder.native().starts_with("/proc/")) return {path, true};
    const fs::path link = fs::read_symlink(current, error);
    if (error) break;
    current = current.parent_path() / link;
  }
  const fs::file_status status = fs::status(current, error);
  if (fs::is_directory(status)) {
    throw Error(Code::file_unwritable, path.string(), "is a folder", "give the name of a file");
  }
  return {current, fs::exists(status) && !fs::is_regular_file(status)};
}

void write_all(int descriptor, std::string_view content, const fs::path& path) {
  while (!content.empty()) {
    // Linux writes at most 2^31 - 4096 bytes per call.
    const ssize_t written = ::write(descriptor, content.data(), std::min(content.size(), std::size_t{1} << 30));
    if (written < 0) {
      if (errno == EINTR) continue;
      fail_to_write(path, errno);
    }
    content.remove_prefix(static_cast<std::size_t>(written));
  }
}

// Creates a new file next to `target`, with the permissions of the file that it will replace.
fs::path create_temporary(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  const fs::path folder = target.parent_path().empty() ? fs::path(".") : target.parent_path();
  for (;;) {
    fs::path name = folder / (".decid-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp");
    Descriptor file(::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (file.is_open()) {
      struct stat old {};
      // Fails harmlessly on a file system without permissions.
      if (::stat(target.c_str(), &old) == 0 && ::fchmod(file.number(), old.st_mode & 0777) != 0) errno = 0;
      return name;
    }
    const int error = errno;
    if (error == EEXIST) continue;  // left behind by a killed process of the same number
    std::error_code ignored;
    if (error == ENOENT && !fs::exists(folder, ignored)) {
      throw Error(Code::file_unwritable, target.string(), "its folder does not exist",
                  "create the folder " + folder.string() + " first");
    }
    if (error == ENOSPC || error == EDQUOT) fail_to_write(target, error);
    throw Error(Code::file_unwritable, target.string(), "cannot be created: " + errno_text(error),
                "choose a folder that exists and that you may write to");
  }
}

}  // namespace

void require_path(const fs::path& path) {
  const std::size_t zero = path.native().find('\0');
  if (zero == std::string::npos) return;
  throw Error(Code::setting_malformed, path.native().substr(0, zero) + "\\0", "is a path with a zero byte",
              "give a path without it");
}

bool path_exists(const fs::path& path) {
  require_path(path);
  std::error_code error;
  const bool exists = fs::exists(path, error);
  if (error)
    throw Error(Code::file_unreadable, path.string(), "cannot be looked up: " + error.message(),
                "check its name, and the permissions of its folder");
  return exists;
}

std::string read_file(const fs::path& path, std::uint64_t limit_bytes) {
  require_path(path);
  const auto refuse_size = [&] {
    throw Error(Code::file_too_large, path.string(), "is larger than " + std::to_string(limit_bytes) + " bytes",
                "check that it is the right file");
  };
  Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) {
    throw Error(opening_failed(errno), path.string(), "cannot be opened: " + errno_text(errno),
                "check the name and the permissions of the file");
  }
  struct stat status {};
  if (::fstat(file.number(), &status) == 0 && S_ISDIR(status.st_mode)) {
    throw Error(Code::file_unreadable, path.string(), "is a folder", "give the name of a file");
  }
  // A file's size may be unknown (a pipe) or change during reading. It only sets the initial size of the buffer, plus
  // one byte to detect the end.
  constexpr std::size_t piece = std::size_t{1} << 16;
  const auto expected = static_cast<std::size_t>(std::max<off_t>(status.st_size, 0));
  if (S_ISREG(status.st_mode) && expected > limit_bytes) refuse_size();
  const std::uint64_t first =
      std::min<std::uint64_t>(std::max(expected + 1, piece), std::max<std::uint64_t>(limit_bytes, 1));
  std::string content(static_cast<std::size_t>(first), '\0');
  std::size_t length = 0;
  for (;;) {
    if (length == content.size()) content.resize(2 * length);
    const ssize_t count = ::read(file.number(), content.data() + length, content.size() - length);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0)
      throw Error(Code::file_unreadable, path.string(), "reading failed: " + errno_text(errno),
                  "check the disk and its mount");
    if (count == 0) break;
    length += static_cast<std::size_t>(count);
    if (length > limit_bytes) refuse_size();
  }
  content.resize(length);
  return content;
}

void write_file(const fs::path& path, std::string_view content) {
  PendingFile pending(path);
  Descriptor file(::open(pending.path().c_str(), O_WRONLY | O_APPEND | O_CLOEXEC));
  if (!file.is_open()) {
    throw Error(Code::file_unwritable, path.string(), "cannot be opened: " + errno_text(errno),
                "check the permissions of the file");
  }
  write_all(file.number(), content, path);
  if (!file.close()) fail_to_write(path, errno);
  pending.commit();
}

PendingFile::PendingFile(fs::path target) : target_(std::move(target)) {
  require_path(target_);
  Target resolved = resolve(target_);
  target_ = std::move(resolved.path);
  committed_ = resolved.direct;
  temporary_ = resolved.direct ? target_ : create_temporary(target_);
}

PendingFile::~PendingFile() {
  if (committed_) return;
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

void PendingFile::commit() {
  if (committed_) return;
  Descriptor file(::open(temporary_.c_str(), O_RDONLY | O_CLOEXEC));
  // The content must reach the disk before the name, or a crash could leave an empty file.
  if (!file.is_open() || !sync(file.number())) fail_to_write(target_, errno);
  if (!file.close()) fail_to_write(target_, errno);
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) {
    throw Error(Code::file_unwritable, target_.string(), "cannot be replaced: " + errno_text(errno),
                "check the permissions of its folder");
  }
  committed_ = true;
  // Makes the rename survive a crash. Some file systems cannot; the file is complete either way.
  const Descriptor folder(::open(temporary_.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.is_open()) static_cast<void>(sync(folder.number()));
}

}  // namespace decid
