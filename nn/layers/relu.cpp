// Rectified linear unit: in training in place, unless the layer before reads its output in backward.
#include "nn/detail/forward.hpp"
#include "nn/layers/detail/layers.hpp"
#include "nn/layers/detail/training_layers.hpp"

namespace decid::nn {

LayerKind parse_relu(Shape src, Words&) {
  return Relu{src};
}

namespace {

template <class T>
class ReluTraining final : public TrainingLayer<T> {
 public:
  ReluTraining(Layer<T>& layer, const TrainingLayer<T>* before)
      : TrainingLayer<T>(layer), in_place_(before == nullptr || !before->backward_reads_dst()) {}

  bool in_place() const override { return in_place_; }
  bool backward_reads_dst() const override { return true; }

  void forward(const TensorView<const T>& src, const TensorView<T>& dst) override {
    if (!in_place_) copy_planes<T>(src, dst);
    for_each_plane(dst.blocks(), dst.shape().channels,
                   [&](int block, int c) { kernels<T>().relu_forward(dst.plane(block, c)); });
  }

  void backward(const TensorView<const T>&, const TensorView<const T>& dst, const TensorView<T>& diff_dst,
                const TensorView<T>* diff_src) override {
    if (diff_src == nullptr) return;
    if (!in_place_) copy_planes<T>(diff_dst, *diff_src);
    for_each_plane(dst.blocks(), dst.shape().channels, [&](int block, int c) {
      kernels<T>().relu_backward(dst.plane(block, c), diff_src->plane(block, c));
    });
  }

 private:
  bool in_place_;
};

}  // namespace

template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Relu&, const TrainingLayer<T>* before) {
  return std::make_unique<ReluTraining<T>>(layer, before);
}

template std::unique_ptr<TrainingLayer<float>> make_training(Layer<float>&, const Relu&, const TrainingLayer<float>*);
template std::unique_ptr<TrainingLayer<double>> make_training(Layer<double>&, const Relu&,
                                                              const TrainingLayer<double>*);

}  // namespace decid::nn
