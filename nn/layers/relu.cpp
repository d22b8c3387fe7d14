// Rectified linear unit in training, in place.
#include "nn/detail/forward.hpp"
#include "nn/layers/detail/training_layers.hpp"

namespace decid::nn {
namespace {

template <class T>
class ReluTraining final : public TrainingLayer<T> {
 public:
  using TrainingLayer<T>::TrainingLayer;

  bool in_place() const override { return true; }
  bool backward_reads_dst() const override { return true; }

  void forward(const TensorView<const T>&, const TensorView<T>& dst) override {
    for_each_plane(dst.blocks(), dst.shape().channels,
                   [&](int block, int c) { kernels<T>().relu_forward(dst.plane(block, c)); });
  }

  void backward(const TensorView<const T>&, const TensorView<const T>& dst, const TensorView<T>&,
                const TensorView<T>* diff_src) override {
    for_each_plane(dst.blocks(), dst.shape().channels, [&](int block, int c) {
      kernels<T>().relu_backward(dst.plane(block, c), diff_src->plane(block, c));
    });
  }
};

}  // namespace

template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Relu&) {
  return std::make_unique<ReluTraining<T>>(layer);
}

template std::unique_ptr<TrainingLayer<float>> make_training(Layer<float>&, const Relu&);
template std::unique_ptr<TrainingLayer<double>> make_training(Layer<double>&, const Relu&);

}  // namespace decid::nn
