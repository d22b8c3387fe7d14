// Convolution with groups and dilation, by the kernels of plain convolutions. A group is one over some channels. With
// dilation d along rows, output rows i, i + d, i + 2 d ... are one over every d-th row of the input: a view. Along
// columns the kernel gets zeros between its taps.
#include <algorithm>
#include <vector>

#include "nn/detail/forward.hpp"
#include "nn/layers/detail/layers.hpp"

namespace decid::nn {
namespace {

/// Every `step`-th row of a block, from row `first` on, of channels from `channel` on.
template <class T>
BlockView<T> rows_from(BlockView<T> view, int channel, int first, int step) {
  return {view.data + channel * view.channel + first * view.row, view.channel, view.row * step};
}

class GroupedConv final : public OperationOf<GroupedConv> {
 public:
  GroupedConv(const Conv2dShape& shape, int groups, int dilation_rows, int dilation_columns)
      : OperationOf({shape.src_channels, shape.src_rows, shape.src_columns},
                    {shape.dst_channels, shape.dst_rows, shape.dst_columns}),
        shape_(shape),
        groups_(groups),
        dilation_rows_(dilation_rows),
        dilation_columns_(dilation_columns),
        group_(shape) {
    group_.src_channels /= groups;
    group_.dst_channels /= groups;
    group_.kernel_columns = (shape.kernel_columns - 1) * dilation_columns + 1;
  }

  std::string text() const override {
    return Conv2d{shape_}.text() + " groups " + std::to_string(groups_) + " dilation " +
           Words::pair(dilation_rows_, dilation_columns_);
  }
  std::vector<OperationParameter> parameters() const override {
    const int inputs = group_.src_channels, taps = inputs * shape_.kernel_rows * shape_.kernel_columns;
    return {{"weight", {shape_.dst_channels, inputs, shape_.kernel_rows, shape_.kernel_columns}, taps, 0},
            {"bias", {shape_.dst_channels}, 0, 0}};
  }
  long long flops() const override {
    return 2LL * dst().size() * group_.src_channels * shape_.kernel_rows * shape_.kernel_columns;
  }
  bool backward_reads_dst() const override { return false; }
  Halo src_halo() const override { return nn::src_halo(shape_); }
  Halo diff_dst_halo() const override {
    Halo halo;
    for (int p = 0; p < dilation_rows_; ++p) {
      const Phase phase = make_phase(p);
      if (phase.shape.dst_rows > 0) halo = larger(halo, diff_halo(phase.shape));
    }
    return {halo.rows * dilation_rows_, halo.columns};
  }

  template <class T>
  void forward_pass(const ForwardPass<T>& pass) const {
    const std::vector<T> weight = spread(pass.parameters[0]);
    for_each_part(pass.src.blocks(), group_.dst_channels, [&](int block, int group, int first, int last) {
      for (int p = 0; p < dilation_rows_; ++p) {
        const Phase phase = make_phase(p);
        if (phase.shape.dst_rows > 0)
          kernels<T>().conv2d_forward(phase.shape, source(pass.src, block, group, phase), weight_of(weight, group),
                                      pass.parameters[1].data() + group * group_.dst_channels,
                                      result(pass.dst, block, group, p), first, last);
      }
    });
  }

  template <class T>
  void backward_pass(const BackwardPass<T>& pass) const {
    const std::vector<T> weight = spread(pass.parameters[0]);
    for_each_part(pass.src.blocks(), group_.dst_channels, [&](int block, int group, int first, int last) {
      weight_gradients(pass, block, group, first, last);
    });
    if (pass.diff_src == nullptr) return;
    map(pass.src, *pass.diff_src, [](T) { return T(0); });  // rows that no output reads
    for_each_part(pass.src.blocks(), group_.src_channels, [&](int block, int group, int first, int last) {
      for (int p = 0; p < dilation_rows_; ++p) {
        const Phase phase = make_phase(p);
        if (phase.shape.dst_rows > 0 && phase.shape.src_rows > 0)
          kernels<T>().conv2d_backward_src(phase.shape, result(pass.diff_dst, block, group, p),
                                           weight_of(weight, group), source(*pass.diff_src, block, group, phase), first,
                                           last);
      }
    });
  }

 private:
  /// Output rows p, p + d, ... of a group, and the input rows that they read, from `first` on.
  struct Phase {
    Conv2dShape shape;
    int first;
  };

  Phase make_phase(int p) const {
    const int d = dilation_rows_;
    if (d == 1) return {group_, 0};
    const auto count = [d](int from, int rows) { return from < rows ? (rows - 1 - from) / d + 1 : 0; };
    Phase phase{group_, ((p - shape_.pad_rows) % d + d) % d};
    phase.shape.pad_rows = (phase.first - (p - shape_.pad_rows)) / d;
    phase.shape.src_rows = count(phase.first, shape_.src_rows);
    phase.shape.dst_rows = count(p, shape_.dst_rows);
    return phase;
  }
  template <class T>
  auto source(const TensorView<T>& tensor, int block, int group, const Phase& phase) const {
    return rows_from(tensor.block(block), group * group_.src_channels, phase.first, dilation_rows_);
  }
  template <class T>
  auto result(const TensorView<T>& tensor, int block, int group, int p) const {
    return rows_from(tensor.block(block), group * group_.dst_channels, p, dilation_rows_);
  }

  /// body(block, group, first and last channel of the group), parts among threads.
  template <class Body>
  void for_each_part(int blocks, int channels, const Body& body) const {
    const int parts = (channels + conv_group - 1) / conv_group;
    for_each_group(blocks, groups_ * parts, 1, [&](int block, int item, int) {
      const int first = item % parts * conv_group;
      body(block, item / parts, first, std::min(first + conv_group, channels));
    });
  }

  std::size_t group_weights() const {
    return static_cast<std::size_t>(group_.dst_channels) * row_weights() *
           static_cast<std::size_t>(group_.kernel_columns);
  }
  /// Rows of taps of one output.
  std::size_t row_weights() const {
    return static_cast<std::size_t>(group_.src_channels) * static_cast<std::size_t>(group_.kernel_rows);
  }
  template <class T>
  const T* weight_of(const std::vector<T>& weight, int group) const {
    return weight.data() + static_cast<std::size_t>(group) * group_weights();
  }
  /// Weights with zeros between the columns.
  template <class T>
  std::vector<T> spread(std::span<const T> weight) const {
    std::vector<T> wide(group_weights() * static_cast<std::size_t>(groups_), T(0));
    const auto columns = static_cast<std::size_t>(shape_.kernel_columns),
               all = static_cast<std::size_t>(group_.kernel_columns),
               step = static_cast<std::size_t>(dilation_columns_);
    for (std::size_t i = 0; i < weight.size(); ++i) wide[i / columns * all + i % columns * step] = weight[i];
    return wide;
  }

  /// Computes the weight gradients of channels [first, last) of a group: the phases' sums one after the other.
  template <class T>
  void weight_gradients(const BackwardPass<T>& pass, int block, int group, int first, int last) const {
    std::vector<T> wide(group_weights()), bias(static_cast<std::size_t>(group_.dst_channels));
    const auto columns = static_cast<std::size_t>(shape_.kernel_columns),
               all = static_cast<std::size_t>(group_.kernel_columns),
               step = static_cast<std::size_t>(dilation_columns_);
    const std::size_t each = row_weights() * columns;  // of an output
    T* const to = pass.gradient(0, block) + static_cast<std::size_t>(group * group_.dst_channels) * each;
    T* const to_bias = pass.gradient(1, block) + group * group_.dst_channels;
    const std::size_t begin = static_cast<std::size_t>(first) * each, end = static_cast<std::size_t>(last) * each;
    std::fill(to + begin, to + end, T(0));
    std::fill(to_bias + first, to_bias + last, T(0));
    for (int p = 0; p < dilation_rows_; ++p) {
      const Phase phase = make_phase(p);
      if (phase.shape.dst_rows == 0) continue;
      kernels<T>().conv2d_backward_weight(phase.shape, source(pass.src, block, group, phase),
                                          result(pass.diff_dst, block, group, p), pass.src.valid_lanes(block),
                                          wide.data(), bias.data(), first, last);
      for (std::size_t i = begin; i < end; ++i) to[i] += wide[i / columns * all + i % columns * step];
      for (int o = first; o < last; ++o) to_bias[o] += bias[static_cast<std::size_t>(o)];
    }
  }

  Conv2dShape shape_;
  int groups_, dilation_rows_, dilation_columns_;
  Conv2dShape group_;  // of one group, with the kernel's columns spread
};

}  // namespace

OperationPointer grouped_conv(const Conv2dShape& shape, int groups, int dilation_rows, int dilation_columns) {
  return std::make_shared<GroupedConv>(shape, groups, dilation_rows, dilation_columns);
}

}  // namespace decid::nn
