// Data sets on disk: an .npz file, a zip archive of NumPy arrays, as numpy.load opens it.
// Members: sway (trials x samples, float32, rad), parameters (trials x 7, or as many as the
// body model has, float64), group (int32), split (uint8),
// and decid.json (0-dimensional array of bytes, dtype S): {"format": 1, "seed": .., "protocol": {...},
// "parameters": ["Kp", ...]}.
// Formats: numpy.lib.format version 1.0; archive members are stored, not deflated, ZIP64 where 4 GiB are exceeded;
// their time is fixed, so equal data sets are equal files. Values start at multiples of 64 bytes of the file.
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

/// Writes the file whole or not at all. Throws Error for a data set that read_npz would refuse.
void write_npz(const std::filesystem::path& path, const Dataset& data);

/// Generates a data set straight into a file: the bytes that write_npz(path, generate(request)) writes, in memory that
/// does not grow with the sway (100 MB, and some 20 bytes a trial).
///
/// The file is made as npz_partial(path) and renamed when it is whole. If that is interrupted - progress returns false
/// (Error), the disk is full (Error), a kill, a power failure - the next call with the same request and program goes on
/// after the last sound chunk of trials, and the finished file has the same bytes. `resumed` is then called once, with
/// the number of trials that are there. ranks, unless null: processes that share the trials, each writing its own into
/// the one file, which lies on a disk that all share; all make this call, and any may stop it. `program` names what
/// makes the bits ("decid 0.1.0"). Throws Error for what generate() refuses, for the unfinished file of another
/// request, if another process is at it, and if `path` cannot be written or is no regular file.
DatasetReport generate_npz(const std::filesystem::path& path, const DatasetRequest& request, const std::string& program,
                           const Progress& progress = {}, const std::function<void(int trials)>& resumed = {},
                           Communicator* ranks = nullptr);

/// What generate_npz writes beside its output until that is whole: the file's beginning, and a journal of it.
struct NpzPartial {
  std::filesystem::path file, journal;
};
NpzPartial npz_partial(const std::filesystem::path& path);

/// About how large the file of a data set is.
std::uint64_t npz_bytes(int count, const sim::Protocol& protocol);

/// Throws Error for anything that is not such a file: not a zip, truncated, a member missing, of another type or shape,
/// non-finite values, groups or splits out of range, a protocol that does not fit the number of samples, parameters of
/// another model than `body_model`.
Dataset read_npz(const std::filesystem::path& path, const sim::BodyModel& body_model = sim::single_pendulum());

/// Throws Error for a data set that may be neither written nor read. `where` names it.
void check_dataset(const Dataset& data, const std::string& where);

/// A data set whose sway is read when it is asked for. Copies share the file.
class StoredDataset {
 public:
  /// A data set in memory.
  StoredDataset(Dataset data);
  /// Throws what read_npz throws; the sway is read once, to check it. A file whose sway is deflated or not its first
  /// member (decid writes none such) is read into memory.
  explicit StoredDataset(const std::filesystem::path& path, const sim::BodyModel& body_model = sim::single_pendulum());

  /// Everything but the sway, which need not be there.
  const Dataset& about() const noexcept { return data_; }
  int trials() const noexcept { return data_.trials(); }
  bool in_memory() const noexcept { return !file_; }
  /// sway_rad: about().samples values of trial `index`. May be called from many threads. Throws Error for an index that
  /// is no trial's, a span of another length, and if the file is shorter than it was.
  void read(int index, std::span<float> sway_rad) const;

 private:
  struct File;
  Dataset data_;
  std::shared_ptr<const File> file_;
};

}  // namespace decid::dataset
