// A trained layer: its computation, its weights and its running statistics. Other headers run it: in training
// (nn/layers/training_layer.hpp) and in inference (nn/inference.hpp). A new kind of layer is an Operation
// (nn/operation.hpp), one file; the kinds here are those that are fused, or need kernels of their own.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "nn/kernels/kernels.hpp"
#include "nn/tensor.hpp"

namespace decid::nn {

/// The maximum number of values of a parameter, or of one sample of a tensor: a gigabyte; indices fit an int.
inline constexpr long long max_values = 1LL << 28;

/// Cross-correlation with bias; any kernel and stride, zero padding smaller than the kernel.
struct Conv2d {
  Conv2dShape shape;

  Shape src() const { return {shape.src_channels, shape.src_rows, shape.src_columns}; }
  Shape dst() const { return {shape.dst_channels, shape.dst_rows, shape.dst_columns}; }
  /// Returns the number of weights of one output.
  int taps() const { return shape.src_channels * shape.kernel_rows * shape.kernel_columns; }
  std::string text() const;
  long long flops() const { return 2LL * dst().size() * taps(); }
};

/// y = W x + b over all values of a sample, in the order channel, row, column.
struct FullyConnected {
  Shape input;
  int outputs;

  Shape src() const { return input; }
  Shape dst() const { return {outputs, 1, 1}; }
  std::string text() const;
  long long flops() const { return 2LL * outputs * input.size(); }
};

/// y = x < 0 ? 0 : x; a NaN stays one, so that a diverged training shows.
struct Relu {
  Shape shape;

  Shape src() const { return shape; }
  Shape dst() const { return shape; }
  std::string text() const { return "relu"; }
  long long flops() const { return shape.size(); }
};

/// Windows without padding; values at the end that do not fill a window are left out.
struct Pool {
  enum class Kind { average, global_average, max } kind;
  PoolShape shape;

  Shape src() const { return {shape.channels, shape.src_rows, shape.src_columns}; }
  Shape dst() const { return {shape.channels, shape.dst_rows, shape.dst_columns}; }
  bool overlaps() const { return shape.stride_rows < shape.kernel_rows || shape.stride_columns < shape.kernel_columns; }
  std::string text() const;
  long long flops() const { return 1LL * dst().size() * shape.kernel_rows * shape.kernel_columns; }
};

/// Normalisation of each channel over batch, rows and columns, y = gamma (x - mean) / sqrt(variance + epsilon) + beta;
/// then, fused with it, ReLU and a pool whose windows do not overlap, if they follow. Ioffe and Szegedy, "Batch
/// normalization", ICML 2015.
struct BatchNorm {
  static constexpr double epsilon = 1e-5;
  static constexpr double momentum = 0.1;  ///< of the running statistics: new = 0.9 old + 0.1 batch, variance unbiased

  Shape shape;
  bool relu = false;
  std::optional<Pool> pool;

  Shape src() const { return shape; }
  Shape dst() const { return pool ? pool->dst() : shape; }
  std::string text() const;
  long long flops() const { return (relu ? 3LL : 2LL) * shape.size() + (pool ? pool->flops() : 0); }
};

/// The mean of each channel over rows and columns, and after all means the standard deviations sqrt(variance +
/// epsilon); the variance divides by the number of values. Snyder et al., "X-vectors", ICASSP 2018.
struct StatisticsPool {
  static constexpr double epsilon = 1e-5;

  Shape shape;

  Shape src() const { return shape; }
  Shape dst() const { return {2 * shape.channels, 1, 1}; }
  std::string text() const { return "statspool"; }
  long long flops() const { return 4LL * shape.size(); }
};

/// The beginning of a residual or concat: passes its input on, and keeps it for the Join that ends the block.
struct Branch {
  Shape shape;
  bool concatenates = false;

  Shape src() const { return shape; }
  Shape dst() const { return shape; }
  std::string text() const { return concatenates ? "concat {" : "residual {"; }
  long long flops() const { return 0; }
};

/// The end of a residual or concat: kept + input, or the channels of both.
struct Join {
  Shape shape, kept;
  bool concatenates = false;

  Shape src() const { return shape; }
  Shape dst() const {
    return {concatenates ? kept.channels + shape.channels : shape.channels, shape.rows, shape.columns};
  }
  std::string text() const { return "}"; }
  long long flops() const { return concatenates ? 0 : shape.size(); }
};

class Operation;

/// A layer in one file (nn/operation.hpp): decid's own, or registered by a program.
struct Extension {
  std::shared_ptr<const Operation> operation;

  Shape src() const;
  Shape dst() const;
  std::string text() const;
  long long flops() const;
};

using LayerKind = std::variant<Conv2d, FullyConnected, BatchNorm, Relu, Pool, StatisticsPool, Branch, Join, Extension>;

/// Returns the number of trained values of a layer of this kind.
std::size_t parameter_count(const LayerKind& kind);

/// A trained tensor.
template <class T>
struct Parameter {
  std::string name;        ///< within the layer: "weight", "bias", "gamma", "beta"
  std::vector<int> shape;  ///< as in the file, row-major; convolutions (out, in, rows, columns)
  int fan_in = 0;          ///< inputs of one output, for He's initialisation; 0: starts at `initial`
  T initial = 0;
  bool decays = false;  ///< L2 regularisation applies (to weights, not to biases or BatchNorm)
  std::vector<T> value;
};

/// A tensor that is measured, not trained: BatchNorm's running mean and variance.
template <class T>
struct RunningStatistics {
  std::string name;
  T initial = 0;
  bool never_negative = false;
  std::vector<T> value;
};

template <class T>
class Layer {
 public:
  /// Creates a layer whose parameters and statistics have their initial values; weights are 0.
  explicit Layer(const LayerKind& kind);

  const LayerKind& kind() const { return kind_; }
  Shape src_shape() const;
  Shape dst_shape() const;
  /// Returns the layer's complete line in an architecture text: "conv 64 3x3 stride 1x1 pad 1x1"; several, joined by
  /// "\n", for lines that are fused into one layer.
  std::string text() const;
  /// Returns the number of lines of text(). The name of a tensor in a file has its line's number, so that fusing lines
  /// renames none.
  std::size_t lines() const;
  /// Returns the floating-point operations of a forward pass of one sample (a fused multiply-add counts 2).
  long long flops() const;

  /// Returns weight and bias of a convolution or fully connected layer, gamma and beta of BatchNorm.
  std::span<Parameter<T>> parameters() { return parameters_; }
  std::span<const Parameter<T>> parameters() const { return parameters_; }
  /// Returns running mean and variance of BatchNorm.
  std::span<RunningStatistics<T>> statistics() { return statistics_; }
  std::span<const RunningStatistics<T>> statistics() const { return statistics_; }

 private:
  LayerKind kind_;
  std::vector<Parameter<T>> parameters_;
  std::vector<RunningStatistics<T>> statistics_;
};

}  // namespace decid::nn
