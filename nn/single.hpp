// One sample at a time, for identification and firmware: channels instead of samples in the lanes, so that no lane is
// idle. Every output is the chain that Network computes in inference, so the bits are the same.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "nn/network.hpp"
#include "nn/pooling.hpp"

namespace decid::nn {

class SingleNetwork {
 public:
  /// Packs the weights of `network`, which must be planned for inference and is not needed afterwards. All memory is
  /// taken here.
  explicit SingleNetwork(const Network<float>& network);

  /// image: one sample, channel-major, input_shape().size() values. output: output_shape().size() values. Throws Error
  /// for spans of another size.
  void run(std::span<const float> image, std::span<float> output);

  const Shape& input_shape() const { return input_shape_; }
  const Shape& output_shape() const { return output_shape_; }
  /// Bytes of weights and of activations.
  std::size_t weight_bytes() const;
  std::size_t activation_bytes() const;

 private:
  /// Blocks of 16 channels, [block][row][column][lane], zeros around each plane.
  struct Map {
    Shape shape;
    int halo = 0;
    std::size_t offset = 0;  // in memory_

    int blocks() const { return (shape.channels + lanes - 1) / lanes; }
    std::ptrdiff_t row() const { return static_cast<std::ptrdiff_t>(shape.columns + 2 * halo) * lanes; }
    std::ptrdiff_t block() const { return row() * (shape.rows + 2 * halo); }
    std::size_t values() const { return static_cast<std::size_t>(blocks() * block()); }
  };
  /// From one map to another, or in place.
  struct Step {
    std::size_t src = 0, dst = 0;  // in maps_
    SingleConv<float> conv{};      // a convolution, if taps > 0; otherwise what follows:
    Affine<float> affine;
    bool relu = false;
    std::optional<Pool> pool;
    std::vector<float> weight, bias;
    std::vector<std::ptrdiff_t> offset;
  };

  float* at(const Map& map) const { return memory_.data() + map.offset + map.halo * (map.row() + lanes); }
  std::size_t add_map(Shape shape);
  void pack(const Stage<float>& stage, Step& step) const;
  void activate(const Step& step) const;

  std::vector<Map> maps_;
  std::vector<Step> steps_;
  AlignedBuffer<float> memory_;
  Shape input_shape_, output_shape_;
};

}  // namespace decid::nn
