// The trials of a data set, a chunk at a time: for data sets larger than memory, and for resuming interrupted ones.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/communicator.hpp"
#include "dataset/sets/dataset.hpp"
#include "sim/simulate.hpp"

namespace decid::dataset {

/// A trial without its sway.
struct TrialRecord {
  sim::Parameters parameters;  ///< SI units
  double peak_to_peak_rad;     ///< of the noise-free sway, which decides who is a parent
  std::int32_t group;          ///< index of its parent; a base trial's own index
};

/// Valid trials in order, and the number of attempts up to the last of them.
struct Chunk {
  std::vector<TrialRecord> trials;
  std::vector<std::span<const float>> sway;  ///< one per trial of this process, rad, with measurement noise
  long long base_attempts = 0, child_attempts = 0;
  std::vector<std::size_t> trials_by_rank = {};  ///< per process, in order; empty: a single process
};

/// Generates base trials first, then children. Memory: two chunks (some 50 MB each) and a few bytes per trial.
class Generator {
 public:
  /// ranks, unless null: processes that share the attempts. All make the same calls; each has the sway of its own
  /// trials. Throws Error for impossible requests, see generate().
  explicit Generator(DatasetRequest request, Communicator* ranks = nullptr);

  const DatasetRequest& request() const noexcept { return request_; }
  int samples() const noexcept { return simulator_.samples(); }
  int trials() const noexcept { return static_cast<int>(group_.size()); }  ///< so far
  bool done() const noexcept { return trials() == request_.count; }
  const std::vector<std::int32_t>& group() const noexcept { return group_; }
  const DatasetReport& report() const noexcept { return report_; }

  /// Returns the next chunk, which stays valid until the call after the next: one may be written while another is
  /// simulated. Simulates some hundred attempts on OpenMP's threads; the chunk may be empty. Neither the size of the
  /// chunks nor threads change the trials. Throws Error if there is no parent, or too few attempts are valid.
  const Chunk& next();

  /// Continues after trials of an earlier run: its chunks, in order, without their sway.
  void restore(const Chunk& chunk);

 private:
  struct Result {
    bool valid;
    double peak_to_peak_rad;
  };

  bool making_children() const noexcept { return trials() >= base_; }
  /// Returns the attempts so far at base trials, or at children once they are made.
  long long attempts_made() const noexcept {
    return making_children() ? report_.child_attempts : report_.base_attempts;
  }
  int attempts_worth_making(int missing) const;
  std::int32_t find_parent(long long attempt) const;
  sim::TrialInput trial_input(long long attempt) const;
  Result finish(long long attempt, std::span<double> sway_rad, std::span<float> stored) const;
  /// Simulates the next attempts. Returns their results; sway: of `own`, this process's attempts, one after the other.
  std::vector<Result> simulate(int attempts, const RankRange& own, std::vector<float>& sway) const;
  void accept(const TrialRecord& trial);
  RankRange own_attempts(int attempts, int rank) const;
  void gather(std::vector<Result>& results) const;

  DatasetRequest request_;
  Communicator* ranks_;
  int base_;
  sim::ParameterTable ranges_;
  sim::Simulator simulator_;
  int max_chunk_;
  struct Buffer {
    std::vector<float> sway;
    Chunk chunk;
  };
  std::array<Buffer, 2> buffers_;
  bool second_ = false;  // selects the next one

  std::vector<std::int32_t> group_;
  std::vector<std::int32_t> parents_;
  std::vector<sim::Parameters> parents_parameters_;
  DatasetReport report_;
};

}  // namespace decid::dataset
