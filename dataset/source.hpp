// Where training takes its trials from: a data set, in memory or on disk, or the simulator, fresh ones by number.
// feed.hpp makes batches of them.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "dataset/image/image.hpp"
#include "dataset/npz/npz.hpp"

namespace decid::dataset {

class TrialSource {
 public:
  virtual ~TrialSource() = default;
  virtual const sim::Protocol& protocol() const = 0;
  /// Names these very trials: sources of equal identity and protocol give equal trials.
  virtual std::string identity() const = 0;
  /// Trials of an epoch. Those of one epoch may be others than those of the next.
  virtual int training_trials() const = 0;
  virtual int validation_trials() const = 0;
  /// How many trials are best asked for at once, 1 or more; more cost memory, fewer time.
  virtual int trials_at_once() const = 0;

  /// take(place, parameters, sway_rad) for the trial at indices[place], in any order and from many threads; sway_rad is
  /// void afterwards. Throws Error for an index that is not from 0 to below the number of trials.
  using Take =
      std::function<void(std::size_t place, const sim::Parameters& parameters, std::span<const float> sway_rad)>;
  virtual void training(int epoch, std::span<const int> indices, const Take& take) const = 0;
  virtual void validation(std::span<const int> indices, const Take& take) const = 0;
  /// Trials that no epoch before `next_epoch` has trained on: the next one's of a stream, else those for validation.
  virtual int unseen_trials() const = 0;
  virtual void unseen(int next_epoch, std::span<const int> indices, const Take& take) const = 0;
};

/// The halves of a data set. Throws Error if one of them is empty.
std::unique_ptr<TrialSource> stored_source(StoredDataset data);

/// Trials simulated when they are asked for, each used in one epoch only. A trial depends on (seed, its number) alone:
/// number n is the first valid one of attempts 1024 n, 1024 n + 1, ... Validation trials are the first numbers. Throws
/// Error for a protocol that is not valid, or less than one trial of either.
std::unique_ptr<TrialSource> stream_source(sim::Protocol protocol, std::uint64_t seed, int trials_per_epoch,
                                           int validation_trials);

}  // namespace decid::dataset
