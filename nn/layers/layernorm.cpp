// Layer normalisation over all values of a sample, with gamma and beta of each channel: PyTorch's GroupNorm(1,
// channels), which for one row and column is its LayerNorm(channels). Ba et al., "Layer normalization", 2016.
#include <cmath>
#include <vector>

#include "nn/kernels/kernels.hpp"
#include "nn/layers/detail/layers.hpp"

namespace decid::nn {
namespace {

constexpr double layernorm_epsilon = 1e-5;

/// Mean and inverse standard deviation of each lane of a block. Sums are chains in double over channel, row and column.
struct Moments {
  double mean[lanes], inverse[lanes];
};

class LayerNorm final : public OperationOf<LayerNorm> {
 public:
  explicit LayerNorm(Shape shape) : OperationOf(shape, shape) {}
  std::string text() const override { return "layernorm"; }
  long long flops() const override { return 8LL * src().size(); }
  bool backward_reads_dst() const override { return false; }
  std::vector<OperationParameter> parameters() const override {
    return {{"gamma", {src().channels}, 0, 1}, {"beta", {src().channels}, 0, 0}};
  }

  template <class T>
  void forward_pass(const ForwardPass<T>& pass) const {
    parallel_for(pass.src.blocks(), [&](int block) {
      const Moments m = moments(pass.src, block);
      each([&](int c, int i, int k) {
        const double x = static_cast<double>(pass.src.row(block, c, i)[k]);
        const double normal = (x - m.mean[k % lanes]) * m.inverse[k % lanes];
        pass.dst.row(block, c, i)[k] =
            static_cast<T>(value(pass.parameters, 0, c) * normal + value(pass.parameters, 1, c));
      });
    });
  }

  /// With normal = (x - mean) inverse and g = gamma dy: dx = inverse (g - mean(g) - normal mean(g normal)).
  template <class T>
  void backward_pass(const BackwardPass<T>& pass) const {
    parallel_for(pass.src.blocks(), [&](int block) {
      const Moments m = moments(pass.src, block);
      const auto normal = [&](int c, int i, int k) {
        return (static_cast<double>(pass.src.row(block, c, i)[k]) - m.mean[k % lanes]) * m.inverse[k % lanes];
      };
      const auto diff = [&](int c, int i, int k) { return static_cast<double>(pass.diff_dst.row(block, c, i)[k]); };
      double sum[lanes] = {}, dot[lanes] = {};
      for (int c = 0; c < src().channels; ++c) {
        const double gamma = value(pass.parameters, 0, c);
        double own_dot[lanes] = {}, own_sum[lanes] = {};
        for (int i = 0; i < src().rows; ++i)
          for (int k = 0; k < src().columns * lanes; ++k) {
            own_sum[k % lanes] += diff(c, i, k);
            own_dot[k % lanes] += diff(c, i, k) * normal(c, i, k);
          }
        for (int l = 0; l < lanes; ++l) {
          sum[l] += gamma * own_sum[l];
          dot[l] += gamma * own_dot[l];
        }
        const int valid = pass.src.valid_lanes(block);
        pass.gradient(0, block)[c] = static_cast<T>(lane_sum(own_dot, valid));
        pass.gradient(1, block)[c] = static_cast<T>(lane_sum(own_sum, valid));
      }
      if (pass.diff_src == nullptr) return;
      each([&](int c, int i, int k) {
        const int l = k % lanes;
        const double own = value(pass.parameters, 0, c) * diff(c, i, k);
        pass.diff_src->row(block, c, i)[k] =
            static_cast<T>(m.inverse[l] * (own - (sum[l] + normal(c, i, k) * dot[l]) / src().size()));
      });
    });
  }

 private:
  template <class T>
  static double value(std::span<const std::span<const T>> parameters, std::size_t parameter, int channel) {
    return static_cast<double>(parameters[parameter][static_cast<std::size_t>(channel)]);
  }
  /// body(channel, row, column * lanes + lane).
  template <class Body>
  void each(const Body& body) const {
    for (int c = 0; c < src().channels; ++c)
      for (int i = 0; i < src().rows; ++i)
        for (int k = 0; k < src().columns * lanes; ++k) body(c, i, k);
  }
  template <class T>
  Moments moments(const TensorView<const T>& x, int block) const {
    Moments m{};
    double squares[lanes] = {};
    each([&](int c, int i, int k) { m.mean[k % lanes] += static_cast<double>(x.row(block, c, i)[k]); });
    for (double& mean : m.mean) mean /= src().size();
    each([&](int c, int i, int k) {
      const double off = static_cast<double>(x.row(block, c, i)[k]) - m.mean[k % lanes];
      squares[k % lanes] += off * off;
    });
    for (int l = 0; l < lanes; ++l) m.inverse[l] = 1 / std::sqrt(squares[l] / src().size() + layernorm_epsilon);
    return m;
  }
};

}  // namespace

OperationPointer parse_layernorm(Shape src, Words&) {
  return std::make_shared<LayerNorm>(src);
}

}  // namespace decid::nn
