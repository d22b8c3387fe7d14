// Average and maximum pooling in training.
#include "nn/detail/forward.hpp"
#include "nn/layers/detail/training_layers.hpp"

namespace decid::nn {
namespace {

template <class T>
class PoolTraining final : public TrainingLayer<T> {
 public:
  PoolTraining(Layer<T>& layer, const Pool& pool) : TrainingLayer<T>(layer), pool_(pool) {}

  void forward(const TensorView<const T>& src, const TensorView<T>& dst) override { pool_forward(pool_, src, dst); }

  void backward(const TensorView<const T>& src, const TensorView<const T>&, const TensorView<T>& diff_dst,
                const TensorView<T>* diff_src) override {
    if (diff_src == nullptr) return;
    for_each_pool_group(pool_, src.blocks(), [&](const PoolShape& part, int block, int first) {
      const BlockView<const T> dy = from_channel(diff_dst.block(block), first);
      const BlockView<T> dx = from_channel(diff_src->block(block), first);
      if (pool_.kind == Pool::Kind::max)
        kernels<T>().max_pool_backward(part, from_channel(src.block(block), first), dy, dx);
      else
        kernels<T>().average_pool_backward(part, dy, dx);
    });
  }

 private:
  Pool pool_;
};

}  // namespace

template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Pool& pool) {
  return std::make_unique<PoolTraining<T>>(layer, pool);
}

template std::unique_ptr<TrainingLayer<float>> make_training(Layer<float>&, const Pool&);
template std::unique_ptr<TrainingLayer<double>> make_training(Layer<double>&, const Pool&);

}  // namespace decid::nn
