// Feeds a training with the images and targets of an epoch's trials, in its order. It prepares the next block while the
// network uses the current one. A trial's data depend only on its epoch and index, not on timing.
//
//   const auto source = stream_source(protocol, seed, 25600, 1000);
//   const ImageMaker images(settings, protocol.samples());
//   const Scaling scaling = measure_scaling(*source, images, 2000);
//   Feed feed(*source, {images, scaling.rows}, scaling.targets, 64, seed, 0, epochs);
//   for (...) { const Feed::Batch batch = feed.next(); ... }  // ceil(25600 / 64) batches an epoch
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "base/batches.hpp"
#include "dataset/source.hpp"

namespace decid::dataset {

/// The conversion of a trial to a network's input. Its references must outlive it.
struct Encoding {
  const ImageMaker& images;
  const RowScaling& rows;  ///< empty: images are not scaled

  /// Encodes a trial. sway: of a trial's length; input: images.shape().size() values.
  void encode(const Sway& sway, std::span<float> input) const;
};

/// Receives the sway of the trial at a place, in any order and from many threads; it is valid only during the call.
using SwaySink = std::function<void(std::size_t place, const Sway& sway)>;
/// Encodes the trials that `produce` passes to its SwaySink. inputs: of place 0, of place 1, ... Trials whose images
/// share lanes (ImageMaker::make_all) wait until there are enough of them; the bits are encode()'s. Throws Error for a
/// place without space, and the errors of `produce`.
void encode_all(const Encoding& encoding, const std::function<void(const SwaySink& take)>& produce,
                std::span<float> inputs);

/// The scaling of images and targets to mean 0 and standard deviation 1.
struct Scaling {
  RowScaling rows;  ///< empty unless the images' settings have standardize_rows
  TargetScaling targets;
};
/// Measures the scaling on the first `trials` training trials of epoch 0, or on all if there are fewer. Throws Error if
/// trials < 1.
Scaling measure_scaling(const TrialSource& source, const ImageMaker& images, int trials);

/// This process's places of a batch that several processes share, in ascending order.
struct BatchSharing {
  int processes = 1;
  std::function<std::vector<int>(int trials)> own = {};  ///< empty: all
};

class Feed {
 public:
  /// Prepares batches of at most `batch` trials (EpochBatches) from epoch `first_epoch` up to `last_epoch`. `seed`
  /// shuffles each epoch. The first epoch begins with its trial first_trial, where a batch must begin. For shared
  /// batches it makes only this process's trials. Source and encoding must outlive the feed. Throws Error if batch < 1,
  /// or no batch begins with first_trial.
  Feed(const TrialSource& source, Encoding encoding, const TargetScaling& targets, int batch, std::uint64_t seed,
       int first_epoch, int last_epoch, BatchSharing sharing = {}, int first_trial = 0);
  /// Waits for the block in preparation.
  ~Feed();
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;

  struct Batch {
    int trials;                      ///< of all processes together
    int own;                         ///< of this process; the values below are of these trials, in their order
    std::span<const float> images;   ///< own x images.shape().size(), row scaling applied
    std::span<const float> targets;  ///< own x parameters, z-scored
  };
  /// Returns the next batch, valid until the next call. Throws the source's errors, and Error after the last epoch.
  Batch next();

 private:
  struct Block {
    int first_batch = 0, last_batch = 0;  // of the epoch
    std::vector<float> images, targets;
  };
  /// Starts the block that begins with batch `next_` of epoch `epoch_`, and advances.
  void start();
  void fill(Block& block, int epoch, std::vector<int> indices) const;
  std::vector<int> own_trials(int trials) const;

  const TrialSource& source_;
  Encoding encoding_;
  TargetScaling targets_;
  EpochBatches batches_;
  int block_batches_;
  std::uint64_t seed_;
  BatchSharing sharing_;
  int epoch_, last_epoch_, next_;  // of the next block to start
  std::vector<int> order_;
  Block current_, coming_;
  int taken_ = 0;              // the next batch of the current block
  std::size_t own_taken_ = 0;  // this process's trials in earlier batches of the block
  struct Making;               // <future> takes the compiler a second to read
  std::unique_ptr<Making> making_;
};

}  // namespace decid::dataset
