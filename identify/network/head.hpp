// What the outputs of a network mean: how many there are, what loss they are trained with, and which parameters they
// stand for. A model names its head; whoever adds one adds it here, and to head_named().
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "dataset/sets/dataset.hpp"
#include "identify/network/mixture.hpp"
#include "nn/tensor.hpp"

namespace decid {

/// Immutable, without data of its own: one serves all models and threads.
class Head {
 public:
  virtual ~Head() = default;

  /// As in model files.
  virtual std::string name() const = 0;
  /// Outputs that a network needs, for so many parameters.
  virtual std::size_t outputs(std::size_t parameters) const = 0;
  /// How targets are to be scaled: as the training's were measured, unless the head needs another scale.
  virtual dataset::TargetScaling scaling(const sim::ParameterTable& table, dataset::TargetScaling measured) const {
    (void)table;
    return measured;
  }
  /// What the last layer's first weights are multiplied with.
  virtual float first_weights() const { return 1.0F; }
  /// Loss of a batch, summed over its trials and the parameters. outputs: shape (outputs, 1, 1); targets: batch x
  /// parameters, z-scored, row-major. diff, of the shape of outputs, gets the gradient of the loss's mean over both,
  /// or balanced derivatives that vanish with it, where the head says so; lanes without a trial get 0. The bits depend
  /// on the batch alone.
  double loss(const nn::TensorView<const float>& outputs, std::span<const float> targets,
              const nn::TensorView<float>& diff) const;
  /// In two steps, for a batch of `trials` of which others have some blocks of 16. First each one's, `parts`
  /// getting loss_parts() values a block; then the sum of all blocks' in their order.
  virtual std::size_t loss_parts(std::size_t parameters) const = 0;
  virtual void loss(const nn::TensorView<const float>& outputs, std::span<const float> targets, int trials,
                    std::size_t parameters, std::span<double> parts, const nn::TensorView<float>& diff) const = 0;
  virtual double total_loss(std::span<const double> parts, std::size_t parameters) const = 0;
  /// The z-scored point estimate of each parameter that one trial's outputs stand for. outputs: as many as outputs()
  /// says for scores.size() parameters. Throws Error for another number.
  virtual void scores(std::span<const float> outputs, std::span<float> scores) const = 0;
  /// Returns true if distribution() returns one.
  virtual bool gives_distribution() const { return false; }
  /// What one trial's outputs say of so many parameters, as shares of the ranges that scaling() was given; empty if
  /// they are point estimates alone. Throws Error for a number of outputs that is not outputs().
  virtual std::optional<Mixture> distribution(std::span<const float> outputs, std::size_t parameters) const {
    (void)outputs;
    (void)parameters;
    return std::nullopt;
  }
};

/// Z-scored parameters themselves, trained with the mean squared error: "point".
const Head& point_head();

/// A distribution, a mixture of so many Gaussians (identify/network/mixture.hpp), 1 to 16, trained with minus the
/// logarithm of its density at the targets by balanced derivatives, a parameter's scaled so that its range is
/// +-sqrt(3): "mixture 1", ... The point estimate is the mean. Throws Error for another number.
const Head& mixture_head(int components);

/// Throws Error for a name that no head has; `where` names the model.
const Head& head_named(const std::string& name, const std::string& where);

}  // namespace decid
