// The order of a training: epochs of batches, an end of each epoch, a stop anywhere. nn::fit runs it, and so does
// decid's training, which has a different source of batches.
#pragma once

#include "base/parallel.hpp"

namespace decid::nn {

/// The position of a training. A checkpoint saves it.
struct LoopPosition {
  int epoch = 0;        ///< epochs that are done
  int batch = 0;        ///< batches of the next one that are done
  double loss_sum = 0;  ///< of these
};

/// The parts of a training. Each call is for the epoch and batch that `at` says, counted from 0.
class TrainingLoop {
 public:
  virtual ~TrainingLoop() = default;
  /// Returns false if no further epoch is wanted.
  virtual bool wants_epoch(const LoopPosition& at) = 0;
  /// Loads a batch's samples, before the team of threads in which train_batch() runs.
  virtual void load_batch(const LoopPosition&) {}
  /// Trains on a batch and returns the sum of its losses.
  virtual double train_batch(const LoopPosition& at) = 0;
  /// `at` counts the batch now. Returns false to stop.
  virtual bool after_batch(const LoopPosition& at) = 0;
  /// All batches are done; `at` still counts the epoch as the next. Validates, logs.
  virtual void end_epoch(const LoopPosition& at) = 0;
  /// `at` now includes the epoch, so the state can be saved.
  virtual void after_epoch(const LoopPosition& at) = 0;
};

/// Runs up to `epochs` epochs of `batches` batches from `at` on, and moves it. Returns false if after_batch() stopped
/// it; a stop at an epoch's last batch ends the epoch first.
inline bool run(TrainingLoop& loop, LoopPosition& at, int epochs, int batches) {
  while (at.epoch < epochs && loop.wants_epoch(at)) {
    bool stop = false;
    while (at.batch < batches) {
      loop.load_batch(at);
      with_team([&] { at.loss_sum += loop.train_batch(at); });
      ++at.batch;
      stop = !loop.after_batch(at);
      if (stop && at.batch < batches) return false;
    }
    loop.end_epoch(at);
    at = {at.epoch + 1, 0, 0.0};
    loop.after_epoch(at);
    if (stop) return false;
  }
  return true;
}

}  // namespace decid::nn
