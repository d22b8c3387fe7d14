// Leaky rectified linear unit: y = x > 0 ? x : slope x. Maas et al., "Rectifier nonlinearities", ICML 2013.
#include "base/text.hpp"
#include "nn/layers/detail/layers.hpp"

namespace decid::nn {
namespace {

class LeakyRelu final : public OperationOf<LeakyRelu> {
 public:
  LeakyRelu(Shape shape, double slope) : OperationOf(shape, shape), slope_(slope) {}
  std::string text() const override { return format("leakyrelu %.9g", slope_); }
  bool backward_reads_dst() const override { return false; }

  template <class T>
  void forward_pass(const ForwardPass<T>& pass) const {
    map(pass.src, pass.dst, [slope = static_cast<T>(slope_)](T x) { return x > 0 ? x : slope * x; });
  }
  template <class T>
  void backward_pass(const BackwardPass<T>& pass) const {
    map_backward(pass, [slope = static_cast<T>(slope_)](T x, T, T dy) { return x > 0 ? dy : slope * dy; });
  }

 private:
  double slope_;
};

}  // namespace

OperationPointer parse_leaky_relu(Shape src, Words& words) {
  return std::make_shared<LeakyRelu>(src, words.done() ? 0.01 : words.take_number(0, 1));
}

}  // namespace decid::nn
