// Fully connected layer: y = W x + b over all values of a sample, in the order channel, row, column.
#include <algorithm>

#include "nn/layers.hpp"
#include "nn/sharing.hpp"

namespace decid::nn {
namespace {

template <class T>
class FullyConnected final : public Layer<T> {
 public:
  FullyConnected(Shape src, int outputs)
      : Layer<T>(src, {outputs, 1, 1}),
        weight_("weight", {outputs, src.size()}, src.size(), T(0), true),
        bias_("bias", {outputs}, 0, T(0), false) {}

  std::string text() const override { return "fc " + std::to_string(this->dst_shape().channels); }
  long long flops() const override { return 2LL * this->dst_shape().channels * this->src_shape().size(); }

  void plan(int batch, Mode mode) override {
    const std::size_t blocks = Tensor<T>::blocks_of(batch);
    dense_.reserve(blocks * bias_.value.size() * lanes);
    if (mode != Mode::training) return;
    weight_parts_.reserve(blocks * weight_.value.size());
    bias_parts_.reserve(blocks * bias_.value.size());
  }

  void forward(const Tensor<T>& src, const Tensor<T>& dst, Mode) override {
    for_each_group(src.blocks(), this->dst_shape().channels, output_group, [&](int block, int first, int last) {
      // The kernel writes its outputs side by side; a halo, for a padded convolution to come, parts them.
      T* const dense = dst.halo() == 0 ? dst.row(block, 0, 0)
                                       : dense_.data() + static_cast<std::size_t>(block) * bias_.value.size() * lanes;
      kernels<T>().fully_connected_forward(this->src_shape(), const_block_of(src, block), weight_.value.data(),
                                           bias_.value.data(), dense, first, last);
      if (dst.halo() != 0)
        for (int o = first; o < last; ++o) std::copy_n(dense + o * lanes, lanes, dst.row(block, o, 0));
    });
  }

  void backward(const Tensor<T>& src, const Tensor<T>&, const Tensor<T>& diff_dst, const Tensor<T>* diff_src) override {
    const std::size_t weights = weight_.value.size(), biases = bias_.value.size();
    for_each_group(src.blocks(), this->dst_shape().channels, output_group, [&](int block, int first, int last) {
      kernels<T>().fully_connected_backward_weight(
          this->src_shape(), const_block_of(src, block), diff_dst.row(block, 0, 0), src.valid_lanes(block),
          weight_parts_.data() + static_cast<std::size_t>(block) * weights,
          bias_parts_.data() + static_cast<std::size_t>(block) * biases, first, last);
    });
    sum_gradient(weight_parts_, src.blocks(), weight_);
    sum_gradient(bias_parts_, src.blocks(), bias_);
    if (diff_src == nullptr) return;
    for_each_group(src.blocks(), this->src_shape().channels, plane_group, [&](int block, int first, int last) {
      kernels<T>().fully_connected_backward_src(this->src_shape(), this->dst_shape().channels,
                                                diff_dst.row(block, 0, 0), weight_.value.data(),
                                                block_of(*diff_src, block), first, last);
    });
  }

  Stage<T> stage() const override {
    Stage<T> stage;
    stage.fully_connected = true;
    stage.weight = weight_.value.data();
    stage.bias = bias_.value.data();
    return stage;
  }

  std::vector<Parameter<T>*> parameters() override { return {&weight_, &bias_}; }

 private:
  static constexpr int output_group = 64;
  Parameter<T> weight_, bias_;
  AlignedBuffer<T> weight_parts_, bias_parts_;  // gradients of each block of samples
  AlignedBuffer<T> dense_;                      // outputs, where dst has a halo
};

}  // namespace

template <class T>
std::unique_ptr<Layer<T>> make_fully_connected(Shape src, Words& words) {
  const int outputs = words.take_int(1, 65536);
  words.limit(static_cast<long long>(outputs) * src.size(), "weights");
  return std::make_unique<FullyConnected<T>>(src, outputs);
}

template std::unique_ptr<Layer<float>> make_fully_connected(Shape, Words&);
template std::unique_ptr<Layer<double>> make_fully_connected(Shape, Words&);

}  // namespace decid::nn
