// Where training takes its trials from: a data set, in memory or on disk, or the simulator, fresh ones by number.
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

/// Names trials: those of equal identity and protocol are equal.
struct TrialIdentity {
  enum class Kind { unknown, stream, stored } kind = Kind::unknown;
  std::optional<std::uint64_t> seed = {};  ///< that they were drawn from
  std::string sha256 = {};  ///< of a data set: over its parameters, its split and the first million values of sway

  bool operator==(const TrialIdentity&) const = default;
};
TrialIdentity identity_of(const StoredDataset& data);

enum class Part {
  training,    ///< an epoch's; they may change from epoch to epoch
  validation,  ///< the same in every epoch
  unseen       ///< not trained on in any epoch before the one asked for: that epoch's of a stream, else validation
};

class TrialSource {
 public:
  virtual ~TrialSource() = default;
  virtual const sim::Protocol& protocol() const = 0;
  virtual TrialIdentity identity() const = 0;
  virtual int trials(Part part) const = 0;
  /// How many trials to ask for at once, 1 or more: asking for more costs memory, asking for fewer costs time.
  virtual int trials_at_once() const = 0;

  /// Takes the trial at a place: in any order and from many threads; the sway is valid only within the call.
  using Take = std::function<void(std::size_t place, const sim::Parameters& parameters, const Sway& sway)>;
  /// Gives the part's trial at indices[place] to take, for every place. Throws Error for an index that is not from 0 to
  /// below trials(part).
  virtual void take(Part part, int epoch, std::span<const int> indices, const Take& take) const = 0;
};

/// The halves of a data set. Throws Error if one of them is empty.
std::unique_ptr<TrialSource> stored_source(StoredDataset data);

/// Takes the trial at a place: in any order and from many threads; sway_rad may be changed, and is valid only within
/// the call.
using TakeExact = std::function<void(std::size_t place, const sim::TrialInput& trial, std::span<double> sway_rad)>;
/// Simulates the trials of a stream at `numbers`, exact; that of numbers[place] is given to take. Trial `number` is the
/// first valid one of attempts 1024 number, 1024 number + 1, ... of base_trial(): it depends on (seed, number) alone.
void simulate_stream(const sim::Simulator& simulator, std::uint64_t seed, std::span<const std::uint64_t> numbers,
                     const TakeExact& take);

/// Trials simulated when they are asked for, each used in one epoch only, recorded as item `number`.
/// Validation trials are the first numbers. Throws Error for a protocol that is not valid, or fewer than one trial of
/// either.
std::unique_ptr<TrialSource> stream_source(sim::Protocol protocol, std::uint64_t seed, int trials_per_epoch,
                                           int validation_trials);

}  // namespace decid::dataset
