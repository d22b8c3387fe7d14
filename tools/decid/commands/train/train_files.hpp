// The files of a training: the model and the files beside it during training, the lock against other writers, and the
// previous contents.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/files/disk_file.hpp"
#include "base/files/file.hpp"

namespace decid::tools {

/// The names of a training's files: the model and the files beside it.
struct TrainFiles {
  explicit TrainFiles(const std::string& output)
      : model(output),
        checkpoint(output + ".checkpoint"),
        log(output + ".log.csv"),
        best(output + ".best"),
        stopped(output + ".stopped"),
        lock(output + ".lock") {}
  std::string model, checkpoint, log;
  std::string best;     ///< with patience: the model of the best epoch so far
  std::string stopped;  ///< a checkpoint in the middle of an epoch
  std::string lock;

  /// The files that the end of an epoch writes or removes.
  std::vector<std::string> of_epochs() const { return {checkpoint, log, best, stopped}; }
  std::array<std::string, 6> all() const { return {model, checkpoint, log, best, stopped, lock}; }
};

/// Locks an output during its training: another training would write the same files.
class OutputLock {
 public:
  explicit OutputLock(const TrainFiles& files) : file_(files.lock, DiskFile::Access::write) {
    if (!file_.try_lock() || !is_ours())
      throw Error(Code::file_in_use, files.model, "is being trained by another decid",
                  "wait for it, or choose another output (-o)");
  }
  ~OutputLock() { remove(); }
  OutputLock(const OutputLock&) = delete;
  OutputLock& operator=(const OutputLock&) = delete;

 private:
  /// Returns false if another training ended in between and removed the lock file.
  bool is_ours() const {
    try {
      return file_.is_still_at_its_path();
    } catch (const Error&) {
      remove();
      throw;
    }
  }
  void remove() const {
    std::error_code ignored;
    std::filesystem::remove(file_.path(), ignored);
  }

  DiskFile file_;
};

/// Keeps the previous contents of files, to restore them if the work yields nothing useful.
class Before {
 public:
  explicit Before(const std::vector<std::string>& paths) {
    for (const std::string& path : paths)
      if (!path.empty())
        files_.emplace_back(
            path, std::filesystem::exists(path) ? std::optional(read_file(path, max_own_file_bytes)) : std::nullopt);
  }
  void put_back() const {
    for (const auto& [path, bytes] : files_) {
      if (bytes)
        write_file(path, *bytes);
      else
        std::filesystem::remove(path);
    }
  }

 private:
  std::vector<std::pair<std::string, std::optional<std::string>>> files_;
};

}  // namespace decid::tools
