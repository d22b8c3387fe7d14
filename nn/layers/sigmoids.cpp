// tanh, sigmoid 1 / (1 + exp(-x)) and GELU x Phi(x), with decid's own elementary functions: the same bits everywhere.
// Hendrycks and Gimpel, "Gaussian error linear units", 2016.
#include <cmath>

#include "base/math/math.hpp"
#include "nn/layers/detail/layers.hpp"

namespace decid::nn {
namespace {

/// y = F::value(x) with derivative F::slope(x, y).
template <class F>
class Sigmoid final : public OperationOf<Sigmoid<F>> {
 public:
  explicit Sigmoid(Shape shape) : OperationOf<Sigmoid<F>>(shape, shape) {}
  std::string text() const override { return F::name; }

  template <class T>
  void forward_pass(const ForwardPass<T>& pass) const {
    map(pass.src, pass.dst, [](T x) { return static_cast<T>(F::value(static_cast<double>(x))); });
  }
  template <class T>
  void backward_pass(const BackwardPass<T>& pass) const {
    map_backward(pass, [](T x, T y, T dy) {
      return dy * static_cast<T>(F::slope(static_cast<double>(x), static_cast<double>(y)));
    });
  }
};

struct Tanh {
  static constexpr const char* name = "tanh";
  static double value(double x) {
    const double size = std::abs(x);
    if (!(size < 20)) return x > 0 ? 1 : x < 0 ? -1 : x;  // NaN stays one
    const double square = exp(2 * size), y = (square - 1) / (square + 1);
    return x < 0 ? -y : y;
  }
  static double slope(double, double y) { return 1 - y * y; }
};

struct Logistic {
  static constexpr const char* name = "sigmoid";
  static double value(double x) { return 1 / (1 + exp(-x)); }
  static double slope(double, double y) { return y * (1 - y); }
};

struct Gelu {
  static constexpr const char* name = "gelu";
  static double value(double x) { return x * normal_distribution(x); }
  static double slope(double x, double) { return normal_distribution(x) + x * normal_density(x); }
};

}  // namespace

OperationPointer parse_tanh(Shape src, Words&) {
  return std::make_shared<Sigmoid<Tanh>>(src);
}
OperationPointer parse_sigmoid(Shape src, Words&) {
  return std::make_shared<Sigmoid<Logistic>>(src);
}
OperationPointer parse_gelu(Shape src, Words&) {
  return std::make_shared<Sigmoid<Gelu>>(src);
}

}  // namespace decid::nn
