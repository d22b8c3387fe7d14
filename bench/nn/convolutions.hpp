// The convolutions that are timed, alone and beside other libraries': batches of 32 samples, channels in the groups
// that layers pass, so that data comes from where it would in training.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

#include "bench/machine.hpp"
#include "nn/kernels/kernels.hpp"

namespace decid::bench {

using namespace nn;

inline constexpr int blocks = 2;  // of 16 samples
inline constexpr int group = 16;  // channels a call, as in nn/training/sharing.hpp

/// A batch in memory of its own, values away from zero and from subnormals.
struct Batch {
  AlignedBuffer<float> memory;
  TensorView<float> tensor;
  Batch(Shape shape, Halo halo) {
    const std::size_t count = TensorView<float>::required(shape, blocks * lanes, halo);
    memory.reserve(count);
    tensor = TensorView<float>(memory.data(), shape, blocks * lanes, halo);
    for (std::size_t i = 0; i < count; ++i) memory.data()[i] = static_cast<float>(i * 7919 % 1000) * 0.001F - 0.45F;
    tensor.clear_halo();
  }
  BlockView<float> block(int b) const { return tensor.block(b); }
  BlockView<const float> const_block(int b) const { return tensor.block(b); }
  Plane<float> plane(int b, int channel) const { return tensor.plane(b, channel); }
  Plane<const float> const_plane(int b, int channel) const { return tensor.plane(b, channel); }
};

/// CPU time of this thread.
inline double seconds_of(const std::function<void()>& run) {
  const double start = cpu_seconds();
  run();
  return cpu_seconds() - start;
}

enum class Direction { forward, backward_src, backward_weight };

struct Conv {
  const char* name;
  Conv2dShape shape;
};

constexpr Conv same(const char* name, int src_channels, int dst_channels, int size, int kernel, int stride) {
  const int pad = kernel / 2, dst = (size + 2 * pad - kernel) / stride + 1;
  return {name, {src_channels, size, size, dst_channels, dst, dst, kernel, kernel, stride, stride, pad, pad}};
}

inline constexpr Conv convs[] = {
    same("64-64@55", 64, 64, 55, 3, 1),       same("64-128@27", 64, 128, 27, 3, 1),
    same("128-128@13", 128, 128, 13, 3, 1),   same("2-64@110", 2, 64, 110, 3, 1),
    same("2-8@110", 2, 8, 110, 3, 1),         same("8-16@55", 8, 16, 55, 3, 1),
    same("16-32@27", 16, 32, 27, 3, 1),       same("32-32@27", 32, 32, 27, 3, 1),
    same("32-64@55,3x3/2", 32, 64, 55, 3, 2), same("16-32@55,5x5/2", 16, 32, 55, 5, 2),
};

/// Memory of one convolution and the calls a layer makes.
class ConvRun {
 public:
  explicit ConvRun(const Conv2dShape& s)
      : shape_(s),
        src_({s.src_channels, s.src_rows, s.src_columns}, src_halo(s)),
        dst_({s.dst_channels, s.dst_rows, s.dst_columns}, diff_halo(s)),
        weight_(static_cast<std::size_t>(s.dst_channels * s.src_channels * s.kernel_rows * s.kernel_columns), 0.01F),
        bias_(static_cast<std::size_t>(s.dst_channels), 0.1F) {}

  int channels(Direction d) const { return d == Direction::backward_src ? shape_.src_channels : shape_.dst_channels; }

  void run(const Kernels<float>& k, Direction d, int block, int first, int last) {
    if (d == Direction::forward)
      k.conv2d_forward(shape_, src_.const_block(block), weight_.data(), bias_.data(), dst_.block(block), first, last);
    else if (d == Direction::backward_src)
      k.conv2d_backward_src(shape_, dst_.const_block(block), weight_.data(), src_.block(block), first, last);
    else
      k.conv2d_backward_weight(shape_, src_.const_block(block), dst_.const_block(block), lanes, weight_.data(),
                               bias_.data(), first, last);
  }
  void run_batch(const Kernels<float>& k, Direction d) {
    for (int b = 0; b < blocks; ++b)
      for (int c = 0; c < channels(d); c += group) run(k, d, b, c, std::min(c + group, channels(d)));
  }
  /// Multiplications and additions of one channel of one block; with a stride the taps between positions do not count.
  double channel_flops(Direction d) const {
    const Conv2dShape& s = shape_;
    return 2.0 * lanes * s.src_channels * s.dst_channels * s.kernel_rows * s.kernel_columns * s.dst_rows *
           s.dst_columns / channels(d);
  }

 private:
  Conv2dShape shape_;
  Batch src_, dst_;
  std::vector<float> weight_, bias_;
};

}  // namespace decid::bench
