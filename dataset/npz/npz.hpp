// Data sets on disk: an .npz file, a zip archive of NumPy arrays, as numpy.load opens it. Members: sway (trials x
// samples, float32, rad), parameters (trials x the body model's number, 7 for the single pendulum, float64), group
// (int32), split (uint8), and decid.json (0-dimensional array of bytes, dtype S): {"format": 1, "seed": .., "protocol":
// {...}, "parameters": ["Kp", ...]}. Formats: numpy.lib.format version 1.0; archive members are stored, not deflated,
// with ZIP64 beyond 4 GiB. Their time is fixed, so equal data sets are equal files. Values start at multiples of 64
// bytes of the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "base/communicator.hpp"
#include "dataset/sets/dataset.hpp"

namespace decid::dataset {

inline constexpr int npz_format_version = 1;

/// Writes the file completely or not at all. Throws Error for a data set that read_npz would refuse.
void write_npz(const std::filesystem::path& path, const Dataset& data);

/// Generates a data set directly into a file: the bytes of write_npz(path, generate(request)), with memory that does
/// not grow with the sway (100 MB, and some 20 bytes per trial).
///
/// The file is written as npz_partial(path) and renamed when it is complete. It may be interrupted: progress returns
/// false (Error), the disk is full (Error), a kill, a power failure. The next call with the same request and program
/// then continues after the last sound chunk of trials, and the finished file has the same bytes. It calls `resumed`
/// once, with the number of existing trials.
///
/// ranks, unless null: processes that share the trials. Each writes its own into the one file, which must be on a
/// shared disk; all make this call, and any may stop it. `program` names the program that determines the bits ("decid
/// 0.1.0"). Throws Error for requests that generate() refuses, for the unfinished file of another request, if another
/// process is writing it, and if `path` cannot be written or is not a regular file.
DatasetReport generate_npz(const std::filesystem::path& path, const DatasetRequest& request, const std::string& program,
                           const Progress& progress = {}, const std::function<void(int trials)>& resumed = {},
                           Communicator* ranks = nullptr);

/// The files of an unfinished data set: the file's beginning, and its journal.
struct NpzPartial {
  std::filesystem::path file, journal;
};
NpzPartial npz_partial(const std::filesystem::path& path);

/// Returns the approximate size of a data set's file.
std::uint64_t npz_bytes(int count, const sim::Protocol& protocol);

/// Reads a data set. Throws Error for any other file: not a zip, truncated, a member missing, of another type or shape,
/// non-finite values, groups or splits out of range, a protocol that does not fit the number of samples, parameters of
/// another model than the protocol's.
Dataset read_npz(const std::filesystem::path& path);

/// Throws Error for a data set that must be neither written nor read. `where` names it.
void check_dataset(const Dataset& data, const std::string& where);

/// A data set whose sway is read on demand. Copies share the file.
class StoredDataset {
 public:
  /// Holds a data set in memory.
  StoredDataset(Dataset data);
  /// Opens a file. Throws the errors of read_npz; reads the sway once, to check it. A file whose sway is deflated or
  /// not its first member (which decid never writes) is read into memory.
  explicit StoredDataset(const std::filesystem::path& path);

  /// Returns everything except the sway, which may be absent.
  const Dataset& about() const noexcept { return data_; }
  int trials() const noexcept { return data_.trials(); }
  bool in_memory() const noexcept { return !file_; }
  /// Reads a trial into about().samples values; many threads may call it. Throws Error for an index outside of the data
  /// set, a span of another length, and if the file became shorter.
  void read(int index, std::span<float> sway_rad) const;

  /// Receives the trial at a place, in any order and from many threads; the sway is valid only during the call.
  using Take = std::function<void(std::size_t place, std::span<const float> sway_rad)>;
  /// Reads the trial at indices[place] for every place. Throws the errors of read().
  void take(std::span<const int> indices, const Take& take) const;
  /// Does the same for trials first .. first + count - 1.
  void take(int first, int count, const Take& take) const;

 private:
  struct File;
  Dataset data_;
  std::shared_ptr<const File> file_;
};

}  // namespace decid::dataset
