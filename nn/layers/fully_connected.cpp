// Fully connected layer: y = W x + b over all values of a sample, in the order channel, row, column.
#include "nn/detail/forward.hpp"
#include "nn/layers/detail/layers.hpp"
#include "nn/layers/detail/training_layers.hpp"

namespace decid::nn {

LayerKind parse_fully_connected(Shape src, Words& words) {
  const int outputs = words.take_int(1, 65536);
  words.limit(static_cast<long long>(outputs) * src.size(), "weights");
  return FullyConnected{src, outputs};
}

std::string FullyConnected::text() const {
  return "fc " + std::to_string(outputs);
}

namespace {

template <class T>
class FullyConnectedTraining final : public TrainingLayer<T> {
 public:
  FullyConnectedTraining(Layer<T>& layer, const FullyConnected& fc, int max_batch) : TrainingLayer<T>(layer), fc_(fc) {
    const std::size_t blocks = TensorView<T>::count_blocks(max_batch);
    weight_parts_.reserve(blocks * weight().size());
    bias_parts_.reserve(blocks * bias().size());
    dense_.reserve(blocks * bias().size() * lanes);
  }

  void forward(const TensorView<const T>& src, const TensorView<T>& dst) override {
    fully_connected_forward(src, weight(), bias(), dst, dense_);
  }

  void backward(const TensorView<const T>& src, const TensorView<const T>&, const TensorView<T>& diff_dst,
                const TensorView<T>* diff_src) override {
    for_each_group(src.blocks(), fc_.outputs, output_group, [&](int block, int first, int last) {
      const auto part = static_cast<std::size_t>(block);
      kernels<T>().fully_connected_backward_weight(
          fc_.input, src.block(block), diff_dst.row(block, 0, 0), src.valid_lanes(block),
          weight_parts_.data() + part * weight().size(), bias_parts_.data() + part * bias().size(), first, last);
    });
    sum_gradients<T>({{weight_parts_.data(), this->gradient(0)}, {bias_parts_.data(), this->gradient(1)}}, src.blocks(),
                     this->all_reduce());
    if (diff_src == nullptr) return;
    for_each_group(src.blocks(), fc_.input.channels, plane_group, [&](int block, int first, int last) {
      kernels<T>().fully_connected_backward_src(fc_.input, fc_.outputs, diff_dst.row(block, 0, 0), weight().data(),
                                                diff_src->block(block), first, last);
    });
  }

 private:
  const std::vector<T>& weight() const { return this->value(0); }
  const std::vector<T>& bias() const { return this->value(1); }

  FullyConnected fc_;
  AlignedBuffer<T> weight_parts_, bias_parts_;  // gradients of each block of samples
  AlignedBuffer<T> dense_;                      // outputs, where dst has a halo
};

}  // namespace

template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const FullyConnected& fc, int max_batch) {
  return std::make_unique<FullyConnectedTraining<T>>(layer, fc, max_batch);
}

template std::unique_ptr<TrainingLayer<float>> make_training(Layer<float>&, const FullyConnected&, int);
template std::unique_ptr<TrainingLayer<double>> make_training(Layer<double>&, const FullyConnected&, int);

}  // namespace decid::nn
