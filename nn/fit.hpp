// Training in one call. The recipe:
//
//   nn::Network net({1, 28, 28}, "conv 32 3x3 pad 1; relu; maxpool 2; fc 10");    // 1. input shape; layers
//   const nn::Samples samples(images, labels, count);                             // 2. values one after the other
//   const nn::FitLog log = nn::fit(net, samples, {.loss = nn::cross_entropy()});  // 3. epochs and validation
//   const std::vector<float> outputs = nn::predict(net, others);                  // 4. any number of samples
//   nn::write_network(net, "net.safetensors");                                    // 5. of nn/network_file.hpp
//
// The input shape is {channels, rows, columns}.
//
// Equal arguments give equal bits, for any number of threads, instruction set and compiler. For a loop of your own:
// nn/training/trainer.hpp.
//
// Several threads may fit different networks at once, and call predict(), mean_loss() and accuracy() with one network.
// No other call may use a network while fit() changes it, except that fit()'s callbacks may read it. After fork() a
// child must not call these functions, unless its parent only used one thread: see base/parallel.hpp.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/math/random.hpp"
#include "nn/network.hpp"
#include "nn/training/loss.hpp"
#include "nn/training/optimiser.hpp"

namespace decid::nn {

/// Where samples come from: memory, or a function that makes them.
class Samples {
 public:
  /// Writes sample `sample`, from 0: its input, channel-major, and its target (Loss::targets() values). `random`:
  /// numbers of this epoch and sample for augmentation, the same for any number of threads; null where samples are not
  /// to be changed, in validation. Several threads call it at once. The values are NaN before the call, and fit()
  /// refuses any that are not finite after it.
  using Load = std::function<void(int sample, const Random* random, std::span<float> input, std::span<float> target)>;

  /// Samples to write together, one after the other.
  struct Batch {
    std::span<const int> samples;    ///< their numbers, from 0
    int epoch;                       ///< of the fit, from 1; 0 outside of a fit
    std::span<const Random> random;  ///< as Load's, one for each sample; empty in validation
    std::span<float> inputs, targets;
  };
  /// Writes the samples of a step, or of a part of validation. fit() calls it from its own thread, in the order of
  /// steps, and outside of parallel regions: OpenMP loops in it have all threads.
  using LoadBatch = std::function<void(const Batch&)>;

  Samples(int count, Load load);
  Samples(int count, LoadBatch load_batch);
  /// Views memory, which must outlive this: `count` inputs one after the other, and as many targets. Throws Error
  /// unless the spans divide by count.
  Samples(std::span<const float> inputs, std::span<const float> targets, int count);

  int count() const { return count_; }
  /// Returns the function of one sample; with load_batch() it calls that.
  const Load& load() const { return load_; }
  const LoadBatch& load_batch() const { return load_batch_; }  ///< may be empty
  /// Return samples in memory, by which fit() compares a checkpoint; empty for a function.
  std::span<const float> inputs() const { return inputs_; }
  std::span<const float> targets() const { return targets_; }

 private:
  int count_;
  Load load_;
  LoadBatch load_batch_;
  std::span<const float> inputs_ = {}, targets_ = {};
};

struct FitEpoch {
  int epoch = 0;               ///< from 1
  double training_loss = 0;    ///< mean over the epoch's samples, as they were trained
  double validation_loss = 0;  ///< after the epoch, without dropout and augmentation; NaN if no sample is validated
  double learning_rate = 0;    ///< of the last step
};

struct FitLog {
  std::vector<FitEpoch> epochs;
  int kept = 0;  ///< the epoch whose weights the network has: with patience the best, else the last. A stop within an
                 ///< epoch leaves the last batch's weights, or their average, unless there is a best epoch
  bool finished = true;  ///< false: after_batch stopped the training
};

/// Every setting has a default that trains.
struct FitOptions {
  int epochs = 10;
  int batch = 64;  ///< samples at most; sizes differ by 1 at most
  double learning_rate = 1e-3;
  std::string schedule = "cosine";  ///< see nn::Schedule
  double warmup_epochs = 0;         ///< the rate rises linearly at first; then a cosine falls from learning_rate
  std::shared_ptr<const Loss> loss = squared_error();
  std::shared_ptr<const Optimiser> optimiser = adamw();
  double clip_norm = 0;     ///< gradients are scaled to this norm at most; 0: never
  double average = 0;       ///< decay of an exponential moving average of weights and statistics, which the network has
                            ///< in the end, and of which validation losses are: 0.999; 0: none
  int frozen_lines = 0;     ///< the first lines of the architecture whose parameters stay as they are; at most all.
                            ///< BatchNorm in them still uses and moves the statistics of batches
  double validation = 0.1;  ///< fraction of the samples that is drawn for validation and not trained on, rounded to
                            ///< whole samples: 0.1 of 4 samples validates none
  std::optional<Samples> validation_samples = std::nullopt;  ///< validation uses these instead
  int patience = 0;  ///< maximum number of epochs without a lower validation loss, which needs a sample; 0: never stop
  std::uint64_t seed = 1;  ///< of weights, order, augmentation and dropout
  /// A file, written after each epoch and at a stop; if it is there, fit() continues from it. It has the SHA-256 of
  /// samples in memory. It cannot have one of a function's samples, so give the same function again.
  std::string checkpoint = {};
  /// Returns false to stop. batch: from 1, in its epoch; loss: the batch's mean.
  std::function<bool(int epoch, int batch, double loss)> after_batch = {};
  /// While it runs the network has the weights of the last step, also with `average`, whose validation loss it gets:
  /// network and loss then belong to different weights.
  std::function<void(const FitEpoch&)> after_epoch = {};
};

/// Trains `network`. A network with the values of its constructor is initialised from the seed first. Throws Error if
/// only some weights were set, and two or more layers in a chain are still 0, or one whose zeros a relu reads: no
/// gradient reaches them, so call initialise() before setting weights. Another layer of zeros is legal, such as the
/// last one. A checkpoint of a finished fit replaces the network's weights, and fit() then trains no further. With a
/// checkpoint the result has the bits of a training that was never stopped. Throws Error for options that contradict
/// each other or the network, a loss or weight that is no longer finite, and what callbacks, samples, loss and
/// optimiser throw; also for a checkpoint of another architecture, other frozen weights, other samples in memory or
/// options. It does not compare callbacks, or the weights that are trained. After an Error the network has the weights
/// of the last step, not their average or those of the best epoch. BatchNorm's statistics may include one more batch,
/// and an optimiser that throws leaves its step half done.
FitLog fit(Network<float>& network, const Samples& samples, const FitOptions& options = {});

/// Returns the outputs of samples that lie one after the other: output_shape().size() values each, and none without
/// inputs. For calls that
/// follow each other quickly, keep a Predictor (nn/predictor.hpp). Throws Error unless `inputs` are whole samples.
std::vector<float> predict(const Network<float>& network, std::span<const float> inputs);

/// Returns the derivatives of sum(by_output * output) by the inputs, of the outputs that predict() gives: BatchNorm has
/// its running statistics, nothing is dropped. by_output: output_shape().size() values a sample, such as a loss's
/// derivatives. A sample's derivatives have the same bits among any other samples. Throws Error for spans that do not
/// fit together.
std::vector<float> input_gradient(const Network<float>& network, std::span<const float> inputs,
                                  std::span<const float> by_output);

/// Returns the mean loss of samples.
double mean_loss(const Network<float>& network, const Samples& samples, const Loss& loss);
/// Returns the fraction of samples whose largest output is that of the target, a class from 0. A sample with an output
/// that is not finite counts as wrong. Throws Error for a target that is no class of the network, and for a network
/// whose outputs have rows or columns.
double accuracy(const Network<float>& network, const Samples& samples);

}  // namespace decid::nn
