// Sources of trials for training: a data set, in memory or on disk, or a stream of new simulated trials by number.
// feed.hpp makes batches of them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "dataset/image/image.hpp"
#include "dataset/npz/npz.hpp"

namespace decid::dataset {

/// The identity of trials: trials of equal identity and protocol are equal.
struct TrialIdentity {
  enum class Kind { unknown, stream, stored } kind = Kind::unknown;
  std::optional<std::uint64_t> seed = {};  ///< the seed of their random numbers
  std::string sha256 = {};  ///< of a data set: over its parameters, its split and the first million values of sway

  bool operator==(const TrialIdentity&) const = default;
};
TrialIdentity trial_identity(const StoredDataset& data);

enum class Part {
  training,    ///< an epoch's; may change from epoch to epoch
  validation,  ///< the same in every epoch
  unseen       ///< not trained on in any epoch before the requested one: that epoch's of a stream, else validation
};

class TrialSource {
 public:
  virtual ~TrialSource() = default;
  virtual const sim::Protocol& protocol() const = 0;
  virtual TrialIdentity identity() const = 0;
  virtual int trials(Part part) const = 0;
  /// Returns the preferred number of trials per request, 1 or more: more cost memory, fewer cost time.
  virtual int trials_at_once() const = 0;

  /// Receives the trial at a place, in any order and from many threads; the sway is valid only during the call.
  using Take = std::function<void(std::size_t place, const sim::Parameters& parameters, const Sway& sway)>;
  /// Passes the part's trial at indices[place] to `take`, for every place. Throws Error for an index outside of 0 to
  /// trials(part) - 1.
  virtual void take(Part part, int epoch, std::span<const int> indices, const Take& take) const = 0;
};

/// Makes a source from the halves of a data set. Throws Error if one of them is empty.
std::unique_ptr<TrialSource> stored_source(StoredDataset data);

/// Receives the trial at a place, in any order and from many threads; sway_rad may be changed, and is valid only during
/// the call.
using TakeExact = std::function<void(std::size_t place, const sim::TrialInput& trial, std::span<double> sway_rad)>;
/// Simulates the noise-free trials of a stream at `numbers` and passes that of numbers[place] to `take`. Trial `number`
/// is the first valid one of attempts 1024 number, 1024 number + 1, ... of base_trial(): it depends only on (seed,
/// number).
void simulate_stream(const sim::Simulator& simulator, std::uint64_t seed, std::span<const std::uint64_t> numbers,
                     const TakeExact& take);

/// Makes a source of trials simulated on demand, each used in one epoch only, recorded as item `number`. Validation
/// trials have the first numbers. Throws Error for an invalid protocol, or fewer than one trial of either part.
std::unique_ptr<TrialSource> stream_source(sim::Protocol protocol, std::uint64_t seed, int trials_per_epoch,
                                           int validation_trials);

}  // namespace decid::dataset
