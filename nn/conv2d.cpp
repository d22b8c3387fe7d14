// Two-dimensional convolution (cross-correlation, as everyone's): forward, and backward by hand. Formulas and the order
// of every sum in kernels/kernels.hpp.
#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "nn/layers.hpp"
#include "nn/sharing.hpp"

namespace decid::nn {

int diff_halo(const Conv2dShape& s) {
  // Taps reach (position + pad - tap) / stride: from -(kernel - 1 - pad) / stride to (src - 1 + pad) / stride.
  const auto reach = [](int src, int dst, int kernel, int stride, int pad) {
    return std::max((kernel - 1 - pad) / stride, (src - 1 + pad) / stride - (dst - 1));
  };
  return std::max(reach(s.src_rows, s.dst_rows, s.kernel_rows, s.stride_rows, s.pad_rows),
                  reach(s.src_columns, s.dst_columns, s.kernel_columns, s.stride_columns, s.pad_columns));
}

namespace {

template <class T>
class Conv2d final : public Layer<T> {
 public:
  explicit Conv2d(const Conv2dShape& s)
      : Layer<T>({s.src_channels, s.src_rows, s.src_columns}, {s.dst_channels, s.dst_rows, s.dst_columns}),
        shape_(s),
        weight_("weight", {s.dst_channels, s.src_channels, s.kernel_rows, s.kernel_columns},
                s.src_channels * s.kernel_rows * s.kernel_columns, T(0), true),
        bias_("bias", {s.dst_channels}, 0, T(0), false) {}

  std::string text() const override {
    const auto pair = [](int a, int b) { return std::to_string(a) + "x" + std::to_string(b); };
    return "conv " + std::to_string(shape_.dst_channels) + " " + pair(shape_.kernel_rows, shape_.kernel_columns) +
           " stride " + pair(shape_.stride_rows, shape_.stride_columns) + " pad " +
           pair(shape_.pad_rows, shape_.pad_columns);
  }
  long long flops() const override {
    return 2LL * this->dst_shape().size() * shape_.src_channels * shape_.kernel_rows * shape_.kernel_columns;
  }
  int src_halo() const override { return std::max(shape_.pad_rows, shape_.pad_columns); }
  int diff_dst_halo() const override { return diff_halo(shape_); }

  void plan(int batch, Mode mode) override {
    follower_ = nullptr;
    if (mode != Mode::training) return;
    const std::size_t blocks = Tensor<T>::blocks_of(batch);
    weight_parts_.reserve(blocks * weight_.value.size());
    bias_parts_.reserve(blocks * bias_.value.size());
  }

  void forward(const Tensor<T>& src, const Tensor<T>& dst, Mode mode) override {
    const bool folded = mode == Mode::inference && !folded_weight_.empty();
    const T* const weight = folded ? folded_weight_.data() : weight_.value.data();
    const T* const bias = folded ? folded_bias_.data() : bias_.value.data();
    for_each_group(src.blocks(), shape_.dst_channels, conv_group, [&](int block, int first, int last) {
      if (follower_ != nullptr)
        forward_in_bands(src, dst, block, first, last);
      else
        kernels<T>().conv2d_forward(shape_, const_block_of(src, block), weight, bias, block_of(dst, block), first,
                                    last);
    });
  }

  bool lead(Follower<T>& follower) override {
    follower_ = &follower;
    if (asks_follower()) {
#pragma omp parallel
      reserve_band_scratch();
    }
    return true;
  }
  bool asks_follower() const override {
    return follower_ != nullptr && chain_values(shape_, conv_group) <= most_chains;
  }

  void backward(const Tensor<T>& src, const Tensor<T>&, const Tensor<T>& diff_dst, const Tensor<T>* diff_src) override {
    for_each_group(src.blocks(), shape_.dst_channels, conv_group, [&](int block, int first, int last) {
      if (diff_src == nullptr && asks_follower())
        weight_gradient_in_bands(src, block, first, last);
      else
        kernels<T>().conv2d_backward_weight(shape_, const_block_of(src, block), const_block_of(diff_dst, block),
                                            src.valid_lanes(block), weight_part(block), bias_part(block), first, last);
    });
    sum_gradient(weight_parts_, src.blocks(), weight_);
    sum_gradient(bias_parts_, src.blocks(), bias_);
    if (diff_src == nullptr) return;
    for_each_group(src.blocks(), shape_.src_channels, conv_group, [&](int block, int first, int last) {
      kernels<T>().conv2d_backward_src(shape_, const_block_of(diff_dst, block), weight_.value.data(),
                                       block_of(*diff_src, block), first, last);
    });
  }

  bool fold(const Affine<T>& after) override {
    folded_weight_.clear();
    folded_bias_.clear();
    if (after.scale.empty()) return true;
    const std::size_t outputs = bias_.value.size(), inputs = weight_.value.size() / outputs;
    for (std::size_t i = 0; i < weight_.value.size(); ++i)
      folded_weight_.push_back(weight_.value[i] * after.scale[i / inputs]);
    for (std::size_t o = 0; o < outputs; ++o)
      folded_bias_.push_back(std::fma(bias_.value[o], after.scale[o], after.shift[o]));
    return true;
  }
  Stage<T> stage() const override {
    const bool folded = !folded_weight_.empty();
    Stage<T> stage;
    stage.conv = &shape_;
    stage.weight = folded ? folded_weight_.data() : weight_.value.data();
    stage.bias = folded ? folded_bias_.data() : bias_.value.data();
    return stage;
  }

  std::vector<Parameter<T>*> parameters() override {
    return {&weight_, &bias_};
  }

 private:
  /// Chains of a group of channels that are worth pausing between bands: 256 KB of floats, part of the second-level
  /// cache.
  static constexpr std::size_t most_chains = 1U << 16U;
  /// Values of a group's rows that stay in the second-level cache, and rows at least: so many chains of sums go at
  /// once.
  static constexpr std::size_t forward_values = 1U << 17U;
  static constexpr int forward_rows = 4;

  T* weight_part(int block) const {
    return weight_parts_.data() + static_cast<std::size_t>(block) * weight_.value.size();
  }
  T* bias_part(int block) const {
    return bias_parts_.data() + static_cast<std::size_t>(block) * bias_.value.size();
  }
  /// src under rows of dst from `row` on, padding included.
  View<const T> src_of_band(const Tensor<T>& src, int block, int row) const {
    View<const T> view = const_block_of(src, block);
    view.data += (row * shape_.stride_rows - shape_.pad_rows) * view.row;
    return view;
  }

  /// Channels [first, last) of dst, whose rows the follower sums up while they are in the cache.
  void forward_in_bands(const Tensor<T>& src, const Tensor<T>& dst, int block, int first, int last) {
    double sums[conv_group][2 * lanes] = {};
    const std::size_t row_values = static_cast<std::size_t>((last - first) * shape_.dst_columns) * lanes;
    const int step = std::max(forward_rows, static_cast<int>(forward_values / row_values));
    for (int row = 0; row < shape_.dst_rows; row += step) {
      const int rows = std::min(step, shape_.dst_rows - row);
      View<T> band = block_of(dst, block);
      band.data += row * band.row;
      kernels<T>().conv2d_forward(band_of(shape_, rows), src_of_band(src, block, row), weight_.value.data(),
                                  bias_.value.data(), band, first, last);
      for (int c = first; c < last; ++c)
        follower_->add_rows({band.data + c * band.channel, band.row, rows, shape_.dst_columns}, c, sums[c - first]);
    }
    for (int c = first; c < last; ++c) follower_->keep_sums(sums[c - first], src.valid_lanes(block), block, c);
  }

  /// Scratch of the calling thread for weight_gradient_in_bands: chains, then a band of the group's derivative.
  AlignedBuffer<T>& reserve_band_scratch() const {
    thread_local AlignedBuffer<T> buffer;
    int rows = 0;
    for (int i = 0; i < follower_->bands(); ++i)
      rows = std::max(rows, follower_->band_end(i) - (i > 0 ? follower_->band_end(i - 1) : 0));
    buffer.reserve(chain_values(shape_, conv_group) +
                   static_cast<std::size_t>(conv_group * rows * shape_.dst_columns) * lanes);
    return buffer;
  }

  /// The gradient of channels [first, last), from the follower's derivative a band at a time.
  void weight_gradient_in_bands(const Tensor<T>& src, int block, int first, int last) {
    T* const chains = reserve_band_scratch().data();
    T* const diff = chains + chain_values(shape_, last - first);
    const std::ptrdiff_t diff_row = static_cast<std::ptrdiff_t>(shape_.dst_columns) * lanes;
    for (int i = 0, row = 0; i < follower_->bands(); ++i) {
      const int rows = follower_->band_end(i) - row;
      const std::ptrdiff_t diff_channel = rows * diff_row;
      for (int c = first; c < last; ++c)
        follower_->derivative(block, c, i, {diff + (c - first) * diff_channel, diff_row, rows, shape_.dst_columns});
      kernels<T>().conv2d_weight_chains(band_of(shape_, rows), src_of_band(src, block, row),
                                        {diff, 0, diff_channel, diff_row}, last - first, i == 0, chains);
      row += rows;
    }
    kernels<T>().conv2d_weight_sums(
        shape_, chains, last - first, src.valid_lanes(block),
        weight_part(block) + static_cast<std::size_t>(first) * (weight_.value.size() / bias_.value.size()),
        bias_part(block) + first);
  }

  Conv2dShape shape_;
  Parameter<T> weight_, bias_;
  AlignedBuffer<T> weight_parts_, bias_parts_;  // gradients of each block of samples
  Follower<T>* follower_ = nullptr;             // in training, if BatchNorm comes next
  std::vector<T> folded_weight_, folded_bias_;  // of inference, with the BatchNorm that follows; empty: none
};

}  // namespace

template <class T>
std::unique_ptr<Layer<T>> make_conv2d(Shape src, Words& words) {
  Conv2dShape s{};
  s.src_channels = src.channels;
  s.src_rows = src.rows;
  s.src_columns = src.columns;
  s.dst_channels = words.take_int(1, 4096);
  std::tie(s.kernel_rows, s.kernel_columns) = words.take_pair(1, 255);
  s.stride_rows = s.stride_columns = 1;
  if (words.take_if("stride")) std::tie(s.stride_rows, s.stride_columns) = words.take_pair(1, 255);
  if (words.take_if("pad")) std::tie(s.pad_rows, s.pad_columns) = words.take_pair(0, 254);
  if (s.pad_rows >= s.kernel_rows || s.pad_columns >= s.kernel_columns)
    words.fail("has padding as large as its kernel");
  const auto extent = [&](int size, int kernel, int stride, int pad) {
    if (size + 2 * pad < kernel)
      words.fail("has a kernel larger than its padded input of " + std::to_string(src.rows) + "x" +
                 std::to_string(src.columns));
    return (size + 2 * pad - kernel) / stride + 1;
  };
  s.dst_rows = extent(s.src_rows, s.kernel_rows, s.stride_rows, s.pad_rows);
  s.dst_columns = extent(s.src_columns, s.kernel_columns, s.stride_columns, s.pad_columns);
  words.limit(static_cast<long long>(s.dst_channels) * s.src_channels * s.kernel_rows * s.kernel_columns, "weights");
  return std::make_unique<Conv2d<T>>(s);
}

template std::unique_ptr<Layer<float>> make_conv2d(Shape, Words&);
template std::unique_ptr<Layer<double>> make_conv2d(Shape, Words&);

}  // namespace decid::nn
