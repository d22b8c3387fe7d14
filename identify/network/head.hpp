// The meaning of a network's outputs: their number, the loss that trains them, and the parameters that they stand for.
// A model names its head. To add a head, declare it here and add it to head_named().
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

  /// Returns the name in model files.
  virtual std::string name() const = 0;
  /// Returns the number of outputs of a network for `parameters` parameters.
  virtual std::size_t outputs(std::size_t parameters) const = 0;
  /// Returns the target scaling: the one measured in training, unless the head needs another scale.
  virtual dataset::TargetScaling scaling(const sim::ParameterTable& table, dataset::TargetScaling measured) const {
    (void)table;
    return measured;
  }
  /// Returns the factor of the last layer's initial weights.
  virtual float first_weights() const { return 1.0F; }
  /// Computes the loss of a batch, summed over its trials and the parameters. outputs: shape (outputs, 1, 1); targets:
  /// batch x parameters, z-scored, row-major. diff, of the shape of outputs, gets the gradient of the loss's mean over
  /// both, or balanced derivatives that vanish with it, if the head defines them. Lanes without a trial get 0. The bits
  /// depend only on the batch.
  double loss(const nn::TensorView<const float>& outputs, std::span<const float> targets,
              const nn::TensorView<float>& diff) const;
  /// Computes the loss in two steps, for a batch of `trials` whose blocks of 16 are spread over processes. First each
  /// process writes loss_parts() values per block to `parts`; then total_loss() sums all blocks in order.
  virtual std::size_t loss_parts(std::size_t parameters) const = 0;
  virtual void loss(const nn::TensorView<const float>& outputs, std::span<const float> targets, int trials,
                    std::size_t parameters, std::span<double> parts, const nn::TensorView<float>& diff) const = 0;
  virtual double total_loss(std::span<const double> parts, std::size_t parameters) const = 0;
  /// Computes the z-scored point estimate of each parameter from one trial's outputs. outputs: outputs(scores.size())
  /// values. Throws Error for another number.
  virtual void scores(std::span<const float> outputs, std::span<float> scores) const = 0;
  /// Returns true if distribution() returns one.
  virtual bool gives_distribution() const { return false; }
  /// Returns the distribution of `parameters` parameters in one trial's outputs, as fractions of the ranges passed to
  /// scaling(). Empty if the outputs are only point estimates. Throws Error for a number of outputs that is not
  /// outputs().
  virtual std::optional<Mixture> distribution(std::span<const float> outputs, std::size_t parameters) const {
    (void)outputs;
    (void)parameters;
    return std::nullopt;
  }
};

/// Returns the head "point": outputs are z-scored parameters, trained with the mean squared error.
const Head& point_head();

/// Returns the head "mixture 1", "mixture 2", ...: a mixture of 1 to 16 Gaussians (identify/network/mixture.hpp). The
/// loss is minus the logarithm of its density at the targets, with balanced derivatives. Each parameter is scaled so
/// that its range is +-sqrt(3). The point estimate is the mean. Throws Error for another number.
const Head& mixture_head(int components);

/// Returns the head of that name. Throws Error for a name that no head has; `where` names the setting.
const Head& chosen_head(const std::string& name, const std::string& where);
/// Returns the head of that name. Throws Error for a name that no head has; `where` names the model.
const Head& head_named(const std::string& name, const std::string& where);

}  // namespace decid
