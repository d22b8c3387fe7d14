// Losses: what a training minimises, with the derivative by each output. A loss of your own is a class that overrides
// text() and sample(), or batch() of BatchLoss; nn::fit (nn/fit.hpp) takes it as it takes the ones here.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <type_traits>

#include "nn/tensor.hpp"

namespace decid::nn {

/// The loss of one sample. A batch's loss is the mean over its samples.
class Loss {
 public:
  virtual ~Loss() = default;
  /// Returns the loss of a sample and writes its derivative by each output. `output` has the network's values,
  /// channel-major; `target` has targets(output.size()) values. Several threads call it at once.
  virtual double sample(std::span<const double> output, std::span<const double> target,
                        std::span<double> diff) const = 0;
  /// Writes the losses of samples that lie one after the other, and the derivatives of their mean by each output;
  /// losses.size() is the number of samples. fit() calls it once a step from its own thread, and in validation for some
  /// hundred samples at a time. Calls sample() in several threads. fit() calls it within its team of threads: use
  /// parallel_for() of base/parallel.hpp, as OpenMP's own loops run in one thread there.
  virtual void batch(std::span<const double> outputs, std::span<const double> targets, std::span<double> losses,
                     std::span<double> diffs) const;
  /// Returns how many values a sample's target has if the network has `outputs`.
  virtual int targets(int outputs) const { return outputs; }
  /// Throws Error for outputs of a shape that the loss does not take; the default takes any.
  virtual void require(const Shape& output) const;
  /// Throws Error for a target that the loss does not take if the network has `outputs`; the default takes any. sample:
  /// its number, from 0, for the Error. fit() calls it for samples in memory before the first step.
  virtual void require_target(std::span<const float> target, int outputs, int sample) const;
  /// Returns the name with its settings, by which a checkpoint is compared.
  virtual std::string text() const = 0;
};

/// A loss that computes a batch at once, in batch(); a sample is a batch of one.
class BatchLoss : public Loss {
 public:
  double sample(std::span<const double> output, std::span<const double> target, std::span<double> diff) const final;
  void batch(std::span<const double> outputs, std::span<const double> targets, std::span<double> losses,
             std::span<double> diffs) const override = 0;
};

/// Returns the mean over outputs of (output - target)^2.
std::shared_ptr<const Loss> squared_error();
/// Returns -log of the target's class in softmax(output), with decid's own exp and log: the same bits everywhere. The
/// target is one value, the number of the class from 0; sample() throws Error for any other, and require() for outputs
/// with rows or columns. NaN if an output is not finite.
std::shared_ptr<const Loss> cross_entropy();
/// Returns the mean over outputs of e^2 / 2 for |e| <= delta, else delta (|e| - delta / 2), e = output - target. Huber,
/// "Robust estimation of a location parameter", 1964. Throws Error unless delta > 0.
std::shared_ptr<const Loss> huber(double delta = 1.0);
/// Returns the loss of a text: "squared-error", "cross-entropy" or "huber", which a delta may follow: "huber 0.5".
/// Throws Error for another one.
std::shared_ptr<const Loss> loss_named(const std::string& text);

/// Returns the sum of the losses of a batch (Loss::batch()), sample after sample in double. `targets` has targets()
/// values a sample. `diff`, of the output's shape, gets the derivative of the batch's mean; lanes without a sample get
/// 0. Throws Error for tensors and targets that do not fit together.
template <class T>
double total_loss(const Loss& loss, const std::type_identity_t<TensorView<const T>>& output,
                  std::type_identity_t<std::span<const T>> targets, const TensorView<T>& diff);

/// The errors of a batch, or of one rank's blocks of a batch of `batch` samples in all: parts[block * outputs + o] =
/// sum over the block's samples of (output - target)^2 of output o, in double, a lane tree. targets: samples x outputs,
/// row-major. output: a tensor of shape (outputs, 1, 1). diff, of the same shape, gets d MSE / d output = 2 (output -
/// target) / (batch * outputs), with MSE = sum(parts) / (batch * outputs); lanes without a sample get 0. Throws Error
/// for too few targets or parts, and for tensors of other shapes.
template <class T>
void squared_errors(const std::type_identity_t<TensorView<const T>>& output,
                    std::type_identity_t<std::span<const T>> targets, int batch, std::span<double> parts,
                    const TensorView<T>& diff);

}  // namespace decid::nn
