// What a trained network computes in inference, lowered once from its layers into steps: BatchNorm is folded into the
// convolution before it, w' = w scale, b' = fma(b, scale, shift). Batches and single samples (nn/predictor.hpp) run
// these steps, and so may anyone else: they are all there is.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "nn/network.hpp"

namespace decid::nn {

/// scale x + shift, one pair a channel; empty: x + 0, which makes -0 a 0.
template <class T>
struct Affine {
  std::vector<T> scale, shift;
};

/// A convolution, a fully connected layer, statistics (nn/layers/layer.hpp, StatisticsPool), an activation:
/// pool(relu(affine(x))), each as far as it is there; beginning and end of a residual or concat; or an Operation.
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
  // Of a convolution or fully connected layer:
  Conv2dShape conv{};     ///< a fully connected layer's is the convolution whose only position sees all values
  std::vector<T> weight;  ///< [output][tap], taps by channel, row and column
  std::vector<T> bias;    ///< [output]
  std::vector<T> lane_weight, lane_bias;  ///< the same as [block of 16 outputs][tap][lane] and [output], 0 at the end
  // Of an activation:
  Affine<T> affine;
  bool relu = false;
  std::optional<Pool> pool;
  // Of an end:
  Join join{};
  // Of an operation:
  std::shared_ptr<const Operation> operation;
  std::vector<std::vector<T>> parameters;

  /// Convolution or fully connected: has weights.
  bool sums() const { return kind == Kind::convolution || kind == Kind::fully_connected; }
  /// Works where its input lies.
  bool in_place() const {
    return (kind == Kind::activation && !pool) || kind == Kind::branch || (kind == Kind::join && !join.concatenates);
  }
  /// Zeros that it reads around its input.
  Halo halo() const;
};

/// Immutable, so that any number of threads can share one; it does not need the network any more.
template <class T>
class Inference {
 public:
  explicit Inference(const Network<T>& network) : Inference(network.layers()) {}
  /// Of at least one layer, each with the output of the one before as its input.
  explicit Inference(std::span<const Layer<T>> layers);

  const Shape& input_shape() const { return steps_.front().src; }
  const Shape& output_shape() const { return steps_.back().dst; }
  /// One for each layer of the network, in their order.
  const std::vector<Step<T>>& steps() const { return steps_; }
  /// Values that the last layer reads, if that is fully connected and not the only one; otherwise 0.
  int feature_count() const;
  /// Of weights, in both orders.
  std::size_t bytes() const;

 private:
  std::vector<Step<T>> steps_;
};

}  // namespace decid::nn
