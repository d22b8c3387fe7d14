// Average and maximum pooling over windows without padding; what does not fill a window at the end is left out.
#include "nn/pooling.hpp"

#include "nn/layers.hpp"
#include "nn/sharing.hpp"

namespace decid::nn {
namespace {

template <class T>
class PoolLayer final : public Layer<T> {
 public:
  explicit PoolLayer(const Pool& pool) : Layer<T>(pool.src(), pool.dst()), pool_(pool) {}

  std::string text() const override { return pool_.text(); }
  long long flops() const override {
    return static_cast<long long>(this->dst_shape().size()) * pool_.shape.kernel_rows * pool_.shape.kernel_columns;
  }

  Stage<T> stage() const override {
    Stage<T> stage;
    stage.pool = &pool_;
    return stage;
  }

  void forward(const Tensor<T>& src, const Tensor<T>& dst, Mode) override {
    share(src, [&](const PoolShape& s, int block, int first) {
      pool_forward(pool_.kind, s, from(const_block_of(src, block), first), from(block_of(dst, block), first));
    });
  }

  void backward(const Tensor<T>& src, const Tensor<T>&, const Tensor<T>& diff_dst, const Tensor<T>* diff_src) override {
    if (diff_src == nullptr) return;
    share(src, [&](const PoolShape& s, int block, int first) {
      pool_backward(pool_.kind, s, from(const_block_of(src, block), first),
                    from(const_block_of(diff_dst, block), first), from(block_of(*diff_src, block), first));
    });
  }

 private:
  template <class V>
  static V from(V view, int channel) {
    view.data += channel * view.channel;
    return view;
  }
  template <class Body>
  void share(const Tensor<T>& src, const Body& body) const {
    for_each_group(src.blocks(), pool_.shape.channels, plane_group, [&](int block, int first, int last) {
      PoolShape part = pool_.shape;
      part.channels = last - first;
      body(part, block, first);
    });
  }

  Pool pool_;
};

}  // namespace

std::string Pool::text() const {
  if (kind == Kind::global_average) return "globalavgpool";
  const auto pair = [](int a, int b) { return std::to_string(a) + "x" + std::to_string(b); };
  return (kind == Kind::max ? "maxpool " : "avgpool ") + pair(shape.kernel_rows, shape.kernel_columns) + " stride " +
         pair(shape.stride_rows, shape.stride_columns);
}

std::optional<Pool> parse_pool(Shape src, Words& words) {
  Pool pool{};
  if (words.take_if("maxpool"))
    pool.kind = Pool::Kind::max;
  else if (words.take_if("avgpool"))
    pool.kind = Pool::Kind::average;
  else if (words.take_if("globalavgpool"))
    pool.kind = Pool::Kind::global_average;
  else
    return std::nullopt;
  PoolShape& s = pool.shape;
  s.channels = src.channels;
  s.src_rows = s.kernel_rows = src.rows;
  s.src_columns = s.kernel_columns = src.columns;
  const bool global = pool.kind == Pool::Kind::global_average;
  if (!global) std::tie(s.kernel_rows, s.kernel_columns) = words.take_pair(1, 4096);
  s.stride_rows = s.kernel_rows;
  s.stride_columns = s.kernel_columns;
  if (!global && words.take_if("stride")) std::tie(s.stride_rows, s.stride_columns) = words.take_pair(1, 4096);
  if (s.kernel_rows > s.src_rows || s.kernel_columns > s.src_columns)
    words.fail("has a window larger than its input of " + std::to_string(src.rows) + "x" + std::to_string(src.columns));
  s.dst_rows = (s.src_rows - s.kernel_rows) / s.stride_rows + 1;
  s.dst_columns = (s.src_columns - s.kernel_columns) / s.stride_columns + 1;
  return pool;
}

template <class T>
std::unique_ptr<Layer<T>> make_pool(const Pool& pool) {
  return std::make_unique<PoolLayer<T>>(pool);
}

template std::unique_ptr<Layer<float>> make_pool(const Pool&);
template std::unique_ptr<Layer<double>> make_pool(const Pool&);

}  // namespace decid::nn
