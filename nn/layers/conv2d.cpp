// Two-dimensional convolution (cross-correlation, as in other libraries): its line, forward, and backward by hand.
// Formulas and the order of every sum in kernels/kernels.hpp.
#include <algorithm>
#include <tuple>

#include "nn/detail/forward.hpp"
#include "nn/layers/detail/layers.hpp"
#include "nn/layers/detail/training_layers.hpp"

namespace decid::nn {

LayerKind parse_conv(Shape src, Words& words) {
  Conv2dShape s{};
  int groups = 1, dilation_rows = 1, dilation_columns = 1;
  s.src_channels = src.channels;
  s.src_rows = src.rows;
  s.src_columns = src.columns;
  s.dst_channels = words.take_int(1, 4096);
  std::tie(s.kernel_rows, s.kernel_columns) = words.take_pair(1, 255);
  s.stride_rows = s.stride_columns = 1;
  if (words.take_if("stride")) std::tie(s.stride_rows, s.stride_columns) = words.take_pair(1, 255);
  if (words.take_if("pad")) std::tie(s.pad_rows, s.pad_columns) = words.take_pair(0, 254);
  if (words.take_if("groups")) groups = words.take_int(1, 4096);
  if (words.take_if("dilation")) std::tie(dilation_rows, dilation_columns) = words.take_pair(1, 4096);
  const bool plain = groups == 1 && dilation_rows == 1 && dilation_columns == 1;
  const int reach_rows = (s.kernel_rows - 1) * dilation_rows + 1;
  const int reach_columns = (s.kernel_columns - 1) * dilation_columns + 1;
  if (s.pad_rows >= reach_rows || s.pad_columns >= reach_columns) words.fail("has padding as large as its kernel");
  if (s.src_channels % groups != 0 || s.dst_channels % groups != 0)
    words.fail("has " + std::to_string(groups) + " groups that do not divide its channels, " +
               std::to_string(s.src_channels) + " and " + std::to_string(s.dst_channels));
  if (dilation_rows > 1 && s.stride_rows > 1) words.fail("has both dilation and stride along its rows");
  const auto extent = [&](int size, int kernel, int stride, int pad) {
    if (size + 2 * pad < kernel)
      words.fail("has a kernel larger than its padded input of " + Words::pair(src.rows, src.columns));
    return (size + 2 * pad - kernel) / stride + 1;
  };
  s.dst_rows = extent(s.src_rows, reach_rows, s.stride_rows, s.pad_rows);
  s.dst_columns = extent(s.src_columns, reach_columns, s.stride_columns, s.pad_columns);
  words.limit(static_cast<long long>(s.dst_channels) * (s.src_channels / groups) * reach_rows * reach_columns,
              "weights");
  if (plain) return Conv2d{s};
  return Extension{grouped_conv(s, groups, dilation_rows, dilation_columns)};
}

std::string Conv2d::text() const {
  return "conv " + std::to_string(shape.dst_channels) + " " + Words::pair(shape.kernel_rows, shape.kernel_columns) +
         " stride " + Words::pair(shape.stride_rows, shape.stride_columns) + " pad " +
         Words::pair(shape.pad_rows, shape.pad_columns);
}

Halo src_halo(const Conv2dShape& s) {
  return {s.pad_rows, s.pad_columns};
}

Halo diff_halo(const Conv2dShape& s) {
  // Taps reach (position + pad - tap) / stride: from -(kernel - 1 - pad) / stride to (src - 1 + pad) / stride.
  const auto reach = [](int src, int dst, int kernel, int stride, int pad) {
    return std::max({(kernel - 1 - pad) / stride, (src - 1 + pad) / stride - (dst - 1), 0});
  };
  return {reach(s.src_rows, s.dst_rows, s.kernel_rows, s.stride_rows, s.pad_rows),
          reach(s.src_columns, s.dst_columns, s.kernel_columns, s.stride_columns, s.pad_columns)};
}

namespace {

template <class T>
class Conv2dTraining final : public TrainingLayer<T> {
 public:
  Conv2dTraining(Layer<T>& layer, const Conv2dShape& shape, int max_batch) : TrainingLayer<T>(layer), shape_(shape) {
    const std::size_t blocks = TensorView<T>::count_blocks(max_batch);
    weight_parts_.reserve(blocks * weight().size());
    bias_parts_.reserve(blocks * bias().size());
  }

  Halo src_halo() const override { return nn::src_halo(shape_); }
  Halo diff_dst_halo() const override { return diff_halo(shape_); }
  bool fuse(BatchSums<T>& sums) override {
    sums_ = &sums;
    return true;
  }

  void forward(const TensorView<const T>& src, const TensorView<T>& dst) override {
    if (sums_ == nullptr) {
      conv2d_forward(shape_, src, weight(), bias(), dst);
      return;
    }
    for_each_group(src.blocks(), shape_.dst_channels, conv_group,
                   [&](int block, int first, int last) { forward_in_bands(src, dst, block, first, last); });
  }

  void backward(const TensorView<const T>& src, const TensorView<const T>&, const TensorView<T>& diff_dst,
                const TensorView<T>* diff_src) override {
    for_each_group(src.blocks(), shape_.dst_channels, conv_group, [&](int block, int first, int last) {
      const auto part = static_cast<std::size_t>(block);
      kernels<T>().conv2d_backward_weight(shape_, src.block(block), diff_dst.block(block), src.valid_lanes(block),
                                          weight_parts_.data() + part * weight().size(),
                                          bias_parts_.data() + part * bias().size(), first, last);
    });
    sum_gradients<T>({{weight_parts_.data(), this->gradient(0)}, {bias_parts_.data(), this->gradient(1)}}, src.blocks(),
                     this->all_reduce());
    if (diff_src == nullptr) return;
    for_each_group(src.blocks(), shape_.src_channels, conv_group, [&](int block, int first, int last) {
      kernels<T>().conv2d_backward_src(shape_, diff_dst.block(block), weight().data(), diff_src->block(block), first,
                                       last);
    });
  }

 private:
  /// Values of a group's rows that stay in the second-level cache, and the minimum number of rows, which is the number
  /// of concurrent chains of sums.
  static constexpr std::size_t band_values = 1U << 17U;
  static constexpr int band_rows = 4;

  const std::vector<T>& weight() const { return this->value(0); }
  const std::vector<T>& bias() const { return this->value(1); }

  /// Channels [first, last) of dst, a band of rows at a time, with BatchNorm's sums of each.
  void forward_in_bands(const TensorView<const T>& src, const TensorView<T>& dst, int block, int first, int last) {
    double sums[conv_group][2 * lanes] = {};
    const std::size_t row_values = static_cast<std::size_t>((last - first) * shape_.dst_columns) * lanes;
    const int step = std::max(band_rows, static_cast<int>(band_values / row_values));
    for (int row = 0; row < shape_.dst_rows; row += step) {
      const int rows = std::min(step, shape_.dst_rows - row);
      BlockView<const T> src_band = src.block(block);
      src_band.data += (row * shape_.stride_rows - shape_.pad_rows) * src_band.row;
      BlockView<T> band = dst.block(block);
      band.data += row * band.row;
      kernels<T>().conv2d_forward(make_band(shape_, rows), src_band, weight().data(), bias().data(), band, first, last);
      for (int c = first; c < last; ++c)
        sums_->add_rows({band.data + c * band.channel, band.row, rows, shape_.dst_columns}, c, sums[c - first]);
    }
    for (int c = first; c < last; ++c) sums_->keep(sums[c - first], src.valid_lanes(block), block, c);
  }

  Conv2dShape shape_;
  AlignedBuffer<T> weight_parts_, bias_parts_;  // gradients of each block of samples
  BatchSums<T>* sums_ = nullptr;                // if fused with the BatchNorm behind
};

}  // namespace

template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Conv2d& conv, int max_batch) {
  return std::make_unique<Conv2dTraining<T>>(layer, conv.shape, max_batch);
}

template std::unique_ptr<TrainingLayer<float>> make_training(Layer<float>&, const Conv2d&, int);
template std::unique_ptr<TrainingLayer<double>> make_training(Layer<double>&, const Conv2d&, int);

}  // namespace decid::nn
