// Average and maximum pooling.
#include <tuple>

#include "nn/detail/forward.hpp"
#include "nn/layers/detail/layers.hpp"
#include "nn/layers/detail/training_layers.hpp"

namespace decid::nn {

LayerKind parse_pool(Shape src, Words& words) {
  const bool global = words.name() == "globalavgpool";
  using Kind = Pool::Kind;
  Pool pool{global ? Kind::global_average : words.name() == "maxpool" ? Kind::max : Kind::average, {}};
  PoolShape& s = pool.shape;
  s.channels = src.channels;
  s.src_rows = s.kernel_rows = src.rows;
  s.src_columns = s.kernel_columns = src.columns;
  if (!global) std::tie(s.kernel_rows, s.kernel_columns) = words.take_pair(1, 4096);
  s.stride_rows = s.kernel_rows;
  s.stride_columns = s.kernel_columns;
  if (!global && words.take_if("stride")) std::tie(s.stride_rows, s.stride_columns) = words.take_pair(1, 4096);
  if (!global && !words.done()) {
    if (!words.take_if("pad")) words.finish();
    const auto [pad_rows, pad_columns] = words.take_pair(0, 4095);
    if (pad_rows >= s.kernel_rows || pad_columns >= s.kernel_columns) words.fail("has padding as large as its window");
    if (s.src_rows + 2 * pad_rows < s.kernel_rows || s.src_columns + 2 * pad_columns < s.kernel_columns)
      words.fail("has a window larger than its padded input");
    return Extension{padded_pool(pool, pad_rows, pad_columns)};
  }
  if (s.kernel_rows > s.src_rows || s.kernel_columns > s.src_columns)
    words.fail("has a window larger than its input of " + Words::pair(src.rows, src.columns));
  s.dst_rows = (s.src_rows - s.kernel_rows) / s.stride_rows + 1;
  s.dst_columns = (s.src_columns - s.kernel_columns) / s.stride_columns + 1;
  return pool;
}

std::string Pool::text() const {
  if (kind == Kind::global_average) return "globalavgpool";
  return (kind == Kind::max ? "maxpool " : "avgpool ") + Words::pair(shape.kernel_rows, shape.kernel_columns) +
         " stride " + Words::pair(shape.stride_rows, shape.stride_columns);
}

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
