// tanh, sigmoid 1 / (1 + exp(-x)) and GELU x Phi(x), with decid's own elementary functions: the same bits everywhere.
#include "nn/layers/detail/layers.hpp"

namespace decid::nn {
namespace {

template <Sigmoid kind>
class SigmoidLayer final : public OperationOf<SigmoidLayer<kind>> {
 public:
  explicit SigmoidLayer(Shape shape) : OperationOf<SigmoidLayer<kind>>(shape, shape) {}
  std::string text() const override {
    return kind == Sigmoid::tanh ? "tanh" : kind == Sigmoid::logistic ? "sigmoid" : "gelu";
  }

  template <class T>
  void forward_pass(const ForwardPass<T>& pass) const {
    for_each_plane(pass.src.blocks(), pass.src.shape().channels, [&](int block, int c) {
      kernels<T>().sigmoid_forward(kind, pass.src.plane(block, c), pass.dst.plane(block, c));
    });
  }
  template <class T>
  void backward_pass(const BackwardPass<T>& pass) const {
    if constexpr (kind == Sigmoid::gelu) {
      if (pass.diff_src == nullptr) return;
      for_each_plane(pass.src.blocks(), pass.src.shape().channels, [&](int block, int c) {
        kernels<T>().gelu_backward(pass.src.plane(block, c), pass.diff_dst.plane(block, c),
                                   pass.diff_src->plane(block, c));
      });
    } else {
      map_backward(pass, [](T, T y, T dy) {
        const auto value = static_cast<double>(y);
        return dy * static_cast<T>(kind == Sigmoid::tanh ? 1 - value * value : value * (1 - value));
      });
    }
  }
};

}  // namespace

OperationPointer parse_tanh(Shape src, Words&) {
  return std::make_shared<SigmoidLayer<Sigmoid::tanh>>(src);
}
OperationPointer parse_sigmoid(Shape src, Words&) {
  return std::make_shared<SigmoidLayer<Sigmoid::logistic>>(src);
}
OperationPointer parse_gelu(Shape src, Words&) {
  return std::make_shared<SigmoidLayer<Sigmoid::gelu>>(src);
}

}  // namespace decid::nn
