// Feeds a training: the images and targets of an epoch's trials in its order, made a block ahead while the network
// works on the one before. What a trial gives depends on its epoch and index alone, not on when it is made.
//
//   const auto source = stream_source(protocol, seed, 25600, 1000);
//   const ImageMaker images(settings, protocol.samples());
//   const Scaling scaling = measure_scaling(*source, images, 2000);
//   Feed feed(*source, {images, scaling.rows}, scaling.targets, 64, seed, 0, epochs);
//   for (...) { const Feed::Batch batch = feed.next(); ... }  // ceil(25600 / 64) batches an epoch
#pragma once

#include <cstdint>
#include <functional>
#include <future>
#include <span>
#include <vector>

#include "dataset/source.hpp"

namespace decid::dataset {

/// How a trial becomes a network's input. What it refers to must outlive it.
struct Encoding {
  const ImageMaker& images;
  const RowScaling& rows;  ///< empty: images as they are

  /// sway: of a trial's length; input: images.shape().size() values.
  void encode(const Sway& sway, std::span<float> input) const;
};

/// Takes the sway of the trial at a place: in any order and from many threads; it is valid only within the call.
using TakeSway = std::function<void(std::size_t place, const Sway& sway)>;
/// Encodes the trials that `hand_over` gives to the TakeSway it is called with. inputs: of place 0, of place 1, ...
/// Trials whose images share lanes (ImageMaker::make_all) are kept until there are enough of them; the bits are
/// encode()'s. Throws Error for a place without room, and what hand_over throws.
void encode_all(const Encoding& encoding, const std::function<void(const TakeSway& take)>& hand_over,
                std::span<float> inputs);

/// What brings images and targets to mean 0 and deviation 1.
struct Scaling {
  RowScaling rows;  ///< empty unless the images' settings have standardize_rows
  TargetScaling targets;
};
/// From the first `trials` training trials of epoch 0, or all if there are fewer. Throws Error if trials < 1.
Scaling measure_scaling(const TrialSource& source, const ImageMaker& images, int trials);

class Feed {
 public:
  /// Batches of `batch` trials from epoch `first_epoch` up to `last_epoch`, each in the order that `seed` shuffles it
  /// to; an epoch's last batch is smaller if they do not divide. Source and encoding must outlive the feed. Throws
  /// Error if batch < 1.
  Feed(const TrialSource& source, Encoding encoding, const TargetScaling& targets, int batch, std::uint64_t seed,
       int first_epoch, int last_epoch);
  /// Waits for what is being made.
  ~Feed();
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;

  struct Batch {
    int trials;                      ///< fewer than asked for at the end of an epoch
    std::span<const float> images;   ///< trials x images.shape().size(), row scaling applied
    std::span<const float> targets;  ///< trials x parameters, z-scored
  };
  /// The next batch; valid until the call after it. Throws what the source throws, and Error after the last epoch.
  Batch next();

 private:
  struct Block {
    int trials = 0;
    std::vector<float> images, targets;
  };
  /// Starts the block that begins with trial `first_` of epoch `epoch_`, and moves on.
  void start();
  void fill(Block& block, int epoch, std::vector<int> indices) const;

  const TrialSource& source_;
  Encoding encoding_;
  TargetScaling targets_;
  int batch_, block_trials_;
  std::uint64_t seed_;
  int epoch_, last_epoch_, first_ = 0;  // of the block to be started next
  std::vector<int> order_;
  Block current_, coming_;
  int taken_ = 0;  // trials of the current block
  std::shared_future<void> making_;
};

}  // namespace decid::dataset
