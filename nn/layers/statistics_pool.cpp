// Statistics pooling.
#include "nn/detail/forward.hpp"
#include "nn/layers/detail/layers.hpp"
#include "nn/layers/detail/training_layers.hpp"

namespace decid::nn {

LayerKind parse_statistics_pool(Shape src, Words&) {
  return StatisticsPool{src};
}

namespace {

template <class T>
class StatisticsPoolTraining final : public TrainingLayer<T> {
 public:
  using TrainingLayer<T>::TrainingLayer;

  bool backward_reads_dst() const override { return true; }

  void forward(const TensorView<const T>& src, const TensorView<T>& dst) override { statistics_forward<T>(src, dst); }

  void backward(const TensorView<const T>& src, const TensorView<const T>& dst, const TensorView<T>& diff_dst,
                const TensorView<T>* diff_src) override {
    if (diff_src == nullptr) return;
    const int channels = src.shape().channels;
    for_each_plane(src.blocks(), channels, [&](int block, int channel) {
      kernels<T>().statistics_pool_backward(
          src.plane(block, channel), dst.row(block, channel, 0), dst.row(block, channels + channel, 0),
          diff_dst.row(block, channel, 0), diff_dst.row(block, channels + channel, 0), diff_src->plane(block, channel));
    });
  }
};

}  // namespace

template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const StatisticsPool&) {
  return std::make_unique<StatisticsPoolTraining<T>>(layer);
}

template std::unique_ptr<TrainingLayer<float>> make_training(Layer<float>&, const StatisticsPool&);
template std::unique_ptr<TrainingLayer<double>> make_training(Layer<double>&, const StatisticsPool&);

}  // namespace decid::nn
