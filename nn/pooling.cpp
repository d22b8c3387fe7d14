// Average and maximum pooling over windows without padding; what does not fill a window at the end is left out.
#include "nn/layers.hpp"
#include "nn/sharing.hpp"

namespace decid::nn {
namespace {

enum class Kind { average, global_average, max };

template <class T>
class Pool final : public Layer<T> {
 public:
  Pool(Kind kind, const PoolShape& s)
      : Layer<T>({s.channels, s.src_rows, s.src_columns}, {s.channels, s.dst_rows, s.dst_columns}),
        kind_(kind),
        shape_(s) {}

  std::string text() const override {
    if (kind_ == Kind::global_average) return "globalavgpool";
    const auto pair = [](int a, int b) { return std::to_string(a) + "x" + std::to_string(b); };
    return (kind_ == Kind::max ? "maxpool " : "avgpool ") + pair(shape_.kernel_rows, shape_.kernel_columns) +
           " stride " + pair(shape_.stride_rows, shape_.stride_columns);
  }
  long long flops() const override {
    return static_cast<long long>(this->dst_shape().size()) * shape_.kernel_rows * shape_.kernel_columns;
  }

  void forward(const Tensor<T>& src, const Tensor<T>& dst, Mode) override {
    share(src, [&](const PoolShape& s, int block, int first) {
      const auto run = kind_ == Kind::max ? kernels<T>().max_pool_forward : kernels<T>().average_pool_forward;
      run(s, from(const_block_of(src, block), first), from(block_of(dst, block), first));
    });
  }

  void backward(const Tensor<T>& src, const Tensor<T>&, const Tensor<T>& diff_dst, const Tensor<T>* diff_src) override {
    if (diff_src == nullptr) return;
    share(src, [&](const PoolShape& s, int block, int first) {
      const View<const T> dy = from(const_block_of(diff_dst, block), first);
      const View<T> dx = from(block_of(*diff_src, block), first);
      if (kind_ == Kind::max)
        kernels<T>().max_pool_backward(s, from(const_block_of(src, block), first), dy, dx);
      else
        kernels<T>().average_pool_backward(s, dy, dx);
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
    for_each_group(src.blocks(), shape_.channels, plane_group, [&](int block, int first, int last) {
      PoolShape part = shape_;
      part.channels = last - first;
      body(part, block, first);
    });
  }

  Kind kind_;
  PoolShape shape_;
};

template <class T>
std::unique_ptr<Layer<T>> make_pool(Kind kind, Shape src, Words& words) {
  PoolShape s{};
  s.channels = src.channels;
  s.src_rows = s.kernel_rows = src.rows;
  s.src_columns = s.kernel_columns = src.columns;
  if (kind != Kind::global_average) std::tie(s.kernel_rows, s.kernel_columns) = words.take_pair(1, 4096);
  s.stride_rows = s.kernel_rows;
  s.stride_columns = s.kernel_columns;
  if (kind != Kind::global_average && words.take_if("stride"))
    std::tie(s.stride_rows, s.stride_columns) = words.take_pair(1, 4096);
  if (s.kernel_rows > s.src_rows || s.kernel_columns > s.src_columns)
    words.fail("has a window larger than its input of " + std::to_string(src.rows) + "x" + std::to_string(src.columns));
  s.dst_rows = (s.src_rows - s.kernel_rows) / s.stride_rows + 1;
  s.dst_columns = (s.src_columns - s.kernel_columns) / s.stride_columns + 1;
  return std::make_unique<Pool<T>>(kind, s);
}

}  // namespace

template <class T>
std::unique_ptr<Layer<T>> make_max_pool(Shape src, Words& words) {
  return make_pool<T>(Kind::max, src, words);
}
template <class T>
std::unique_ptr<Layer<T>> make_average_pool(Shape src, Words& words) {
  return make_pool<T>(Kind::average, src, words);
}
template <class T>
std::unique_ptr<Layer<T>> make_global_average_pool(Shape src, Words& words) {
  return make_pool<T>(Kind::global_average, src, words);
}

template std::unique_ptr<Layer<float>> make_max_pool(Shape, Words&);
template std::unique_ptr<Layer<double>> make_max_pool(Shape, Words&);
template std::unique_ptr<Layer<float>> make_average_pool(Shape, Words&);
template std::unique_ptr<Layer<double>> make_average_pool(Shape, Words&);
template std::unique_ptr<Layer<float>> make_global_average_pool(Shape, Words&);
template std::unique_ptr<Layer<double>> make_global_average_pool(Shape, Words&);

}  // namespace decid::nn
