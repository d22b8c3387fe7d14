// Inference of one sample at a time: the lanes hold channels instead of samples, so that no lane is idle. Every output
// is the same chain of operations as in a batch, so the bits are the same.
#pragma once

#include <span>
#include <vector>

#include "nn/inference.hpp"
#include "nn/tensor.hpp"

namespace decid::nn {

/// Runs one sample. Calls of run() and activation() must come one after the other. After construction only these layers
/// allocate: residual, concat, convolutions with groups or dilation, layernorm, and registered layers with parameters;
/// other operations do so in their first call.
class SingleExecutor {
 public:
  /// `inference` must outlive it.
  explicit SingleExecutor(const Inference<float>& inference);

  /// Computes the output. image: one sample, channel-major, input_shape().size() values. output: output_shape().size()
  /// values. features: feature_count() values that the last layer reads, or none.
  void run(std::span<const float> image, std::span<float> output, std::span<float> features = {});
  /// Computes the output of step `step` for an image: steps()[step].dst.size() values, channel-major.
  void activation(std::size_t step, std::span<const float> image, std::span<float> values);
  std::size_t memory_bytes() const { return (memory_.size() + batch_.size()) * sizeof(float); }

 private:
  /// Blocks of 16 channels, [block][row][column][lane], zeros around each plane.
  struct Map {
    Shape shape;
    Halo halo = {};
    std::size_t offset = 0;  // in memory_

    int blocks() const { return (shape.channels + lanes - 1) / lanes; }
    std::ptrdiff_t row() const { return static_cast<std::ptrdiff_t>(shape.columns + 2 * halo.columns) * lanes; }
    std::ptrdiff_t block() const { return row() * (shape.rows + 2 * halo.rows); }
    std::size_t values() const { return static_cast<std::size_t>(blocks() * block()); }
  };
  /// A step of inference from one map to another, or in place.
  struct Edge {
    std::size_t src = 0, dst = 0;        // in maps_
    std::vector<std::ptrdiff_t> offset;  // of each tap
  };

  float* at(const Map& map) {
    return memory_.data() + map.offset + map.halo.rows * map.row() + map.halo.columns * lanes;
  }
  void load(std::span<const float> image);
  void store(const Map& map, std::span<float> values);
  void run_steps(std::size_t count);
  void convolve(const Step<float>& step, const Edge& way);
  void take_statistics(const Edge& way);
  void activate(const Step<float>& step, const Edge& way);
  void join(const Step<float>& step, const Edge& way);
  void operate(const Step<float>& step, const Edge& way);

  const Inference<float>& inference_;
  std::vector<Map> maps_;
  std::vector<Edge> edges_;               // of each step
  std::vector<std::vector<float>> kept_;  // inputs of residuals and concats that are open, channel-major
  std::vector<float> values_;             // of one map, channel-major
  AlignedBuffer<float> batch_;            // an operation's input and output, as a batch of one sample
  AlignedBuffer<float> memory_;
};

}  // namespace decid::nn
