// Feeds a training: the images and targets of an epoch's trials in its order, made a block ahead while the network
// works on the one before. What a trial gives depends on its epoch and index alone, not on when it is made.
#pragma once

#include <future>
#include <span>
#include <vector>

#include "tools/model.hpp"
#include "tools/trials.hpp"

namespace decid::tools {

class Feed {
 public:
  /// Batches of `batch` trials from epoch `first_epoch` up to `last_epoch`, each in the order that `seed` shuffles it
  /// to. Source and model must outlive the feed; of the model only image, rows and targets are used.
  Feed(const TrialSource& source, const Model& model, int batch, std::uint64_t seed, int first_epoch, int last_epoch);
  /// Waits for what is being made.
  ~Feed();
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;

  struct Batch {
    int trials;                      ///< fewer than asked for at the end of an epoch
    std::span<const float> images;   ///< trials x the network's input
    std::span<const float> targets;  ///< trials x 7, z-scored
  };
  /// The next batch; valid until the call after it. Throws what the source throws.
  Batch next();

 private:
  struct Block {
    int trials = 0;
    std::vector<float> images, targets;
  };
  /// The block that begins with trial `first_` of epoch `epoch_`, and moves on.
  void start();
  void fill(Block& block, int epoch, std::vector<int> indices) const;

  const TrialSource& source_;
  const Model& model_;
  int batch_, block_trials_;
  std::uint64_t seed_;
  int epoch_, last_epoch_, first_ = 0;  // of the block to be started next
  std::vector<int> order_;
  Block current_, coming_;
  int taken_ = 0;  // trials of the current block
  std::future<void> making_;
};

}  // namespace decid::tools
