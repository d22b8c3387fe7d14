// Dropout: in training each value is 0 with probability `rate`, else x / (1 - rate); in inference y = x. Counted random
// numbers: backward draws the mask of forward again, and neither threads nor processes change it. Srivastava et al.,
// JMLR 15, 2014.
#include <cmath>

#include "base/text.hpp"
#include "nn/layers/detail/layers.hpp"

namespace decid::nn {
namespace {

class Dropout final : public OperationOf<Dropout> {
 public:
  Dropout(Shape shape, double rate) : OperationOf(shape, shape), rate_(rate) {}
  std::string text() const override { return format("dropout %.9g", rate_); }
  bool is_random() const override { return true; }
  bool backward_reads_dst() const override { return false; }

  template <class T>
  void forward_pass(const ForwardPass<T>& pass) const {
    if (!pass.random) return map(pass.src, pass.dst, [](T x) { return x; });
    drop(pass.random, pass.src, pass.dst);
  }
  template <class T>
  void backward_pass(const BackwardPass<T>& pass) const {
    if (pass.diff_src == nullptr) return;
    if (!pass.random) return map(pass.diff_dst, *pass.diff_src, [](T dy) { return dy; });
    drop(pass.random, pass.diff_dst, *pass.diff_src);
  }

 private:
  /// Drops values. Each lane uses 16 of the 64 bits of a random number: rates are exact to 2^-16.
  template <class T>
  void drop(const StepRandom& random, const TensorView<const T>& src, const TensorView<T>& dst) const {
    constexpr int lanes_each = 4, numbers = lanes / lanes_each;
    const auto limit = static_cast<std::uint64_t>(std::lround(rate_ * 65536));
    const T factor = static_cast<T>(1 / (1 - static_cast<double>(limit) / 65536));
    const Shape s = src.shape();
    for_each_plane(src.blocks(), s.channels, [&](int block, int channel) {
      auto index = static_cast<std::uint64_t>(random.block(block) * s.channels + channel) *
                   static_cast<std::uint64_t>(s.rows * s.columns * numbers);
      for (int i = 0; i < s.rows; ++i) {
        const T* x = src.row(block, channel, i);
        T* y = dst.row(block, channel, i);
        for (int k = 0; k < s.columns * lanes; k += lanes_each) {
          std::uint64_t bits = random.numbers->bits(index++);
          for (int l = k; l < k + lanes_each; ++l, bits >>= 16U) y[l] = (bits & 0xffffU) < limit ? T(0) : factor * x[l];
        }
      }
    });
  }

  double rate_;
};

}  // namespace

OperationPointer parse_dropout(Shape src, Words& words) {
  return std::make_shared<Dropout>(src, words.take_number(0, 0.99));
}

}  // namespace decid::nn
