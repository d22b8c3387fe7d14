// Rectified linear unit, in place: y = x < 0 ? 0 : x (a NaN stays one, so that a diverged training shows).
#include "nn/layers.hpp"
#include "nn/sharing.hpp"

namespace decid::nn {
namespace {

template <class T>
class Relu final : public Layer<T> {
 public:
  explicit Relu(Shape src) : Layer<T>(src, src) {}

  std::string text() const override { return "relu"; }
  long long flops() const override { return this->src_shape().size(); }
  bool in_place() const override { return true; }
  bool backward_reads_dst() const override { return true; }

  Stage<T> stage() const override {
    Stage<T> stage;
    stage.relu = true;
    return stage;
  }

  void forward(const Tensor<T>&, const Tensor<T>& dst, Mode) override {
    for_each_group(dst.blocks(), this->src_shape().channels, plane_group, [&](int block, int first, int last) {
      for (int c = first; c < last; ++c) kernels<T>().relu_forward(plane_of(dst, block, c));
    });
  }

  void backward(const Tensor<T>&, const Tensor<T>& dst, const Tensor<T>&, const Tensor<T>* diff_src) override {
    for_each_group(dst.blocks(), this->src_shape().channels, plane_group, [&](int block, int first, int last) {
      for (int c = first; c < last; ++c)
        kernels<T>().relu_backward(const_plane_of(dst, block, c), plane_of(*diff_src, block, c));
    });
  }
};

}  // namespace

template <class T>
std::unique_ptr<Layer<T>> make_relu(Shape src) {
  return std::make_unique<Relu<T>>(src);
}

template std::unique_ptr<Layer<float>> make_relu(Shape);
template std::unique_ptr<Layer<double>> make_relu(Shape);

}  // namespace decid::nn
