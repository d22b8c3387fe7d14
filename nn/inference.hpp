// The steps of a trained network in inference, lowered once from its layers: BatchNorm is folded into the convolution
// before it, w' = w scale, b' = fma(b, scale, shift). Batches and single samples (nn/predictor.hpp) run these steps.
// The steps describe inference completely, so other programs can run them too.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "nn/network.hpp"

namespace decid::nn {

/// scale x + shift, one pair per channel; empty: x + 0, which makes -0 a 0.
template <class T>
struct Affine {
  std::vector<T> scale, shift;
};

/// A convolution, a fully connected layer, statistics (nn/layers/layer.hpp, StatisticsPool), an activation:
/// pool(relu(affine(x))), each part optional; beginning and end of a residual or concat; or an Operation.
template <class T>
struct Step {
  enum class Kind {
    convolution,
    fully_connected,
    statistics,
    activation,
    branch,
    join,
    operation
  } kind = Kind::activation;
  Shape src, dst;
  // Convolution or fully connected layer:
  Conv2dShape conv{};     ///< a fully connected layer's is the convolution whose only position sees all values
  std::vector<T> weight;  ///< [output][tap], taps by channel, row and column
  std::vector<T> bias;    ///< [output]
  std::vector<T> lane_weight, lane_bias;  ///< the same as [block of 16 outputs][tap][lane] and [output], 0 at the end
  // Activation:
  Affine<T> affine;
  bool relu = false;
  std::optional<Pool> pool;
  // End of a residual or concat:
  Join join{};
  // Operation:
  std::shared_ptr<const Operation> operation;
  std::vector<std::vector<T>> parameters;

  /// Returns true for a convolution or fully connected layer, which have weights.
  bool sums() const { return kind == Kind::convolution || kind == Kind::fully_connected; }
  /// Returns true if the step overwrites its input.
  bool in_place() const {
    return (kind == Kind::activation && !pool) || kind == Kind::branch || (kind == Kind::join && !join.concatenates);
  }
  /// Returns the zeros that the step reads around its input.
  Halo halo() const;
};

/// Inference of one network. Immutable, so that any number of threads can share one. It does not refer to the network.
template <class T>
class Inference {
 public:
  explicit Inference(const Network<T>& network) : Inference(network.layers()) {}
  /// Lowers at least one layer; each layer's input is the output of the layer before.
  explicit Inference(std::span<const Layer<T>> layers);

  const Shape& input_shape() const { return steps_.front().src; }
  const Shape& output_shape() const { return steps_.back().dst; }
  /// Returns one step for each layer of the network, in their order.
  const std::vector<Step<T>>& steps() const { return steps_; }
  /// Returns the number of values that the last layer reads, if it is fully connected and not the only layer; otherwise
  /// 0.
  int feature_count() const;
  /// Returns the bytes of the weights, in both orders.
  std::size_t bytes() const;

 private:
  std::vector<Step<T>> steps_;
};

}  // namespace decid::nn
