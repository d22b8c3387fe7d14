// Batch normalisation of each channel: y = gamma (x - mean) / sqrt(variance + epsilon) + beta, statistics over the
// batch in training, running ones in inference. Ioffe and Szegedy, "Batch normalization", ICML 2015. The batch
// statistics are sums in double around a pivot, the running mean: one pass, and no cancellation once the running mean
// is near the mean.
#include <algorithm>
#include <cmath>

#include "nn/layers.hpp"
#include "nn/sharing.hpp"

namespace decid::nn {
namespace {

template <class T>
class BatchNorm final : public Layer<T> {
 public:
  static constexpr double epsilon = 1e-5;
  static constexpr double momentum = 0.1;  // of the running statistics: new = 0.9 old + 0.1 batch

  explicit BatchNorm(Shape src)
      : Layer<T>(src, src),
        channels_(static_cast<std::size_t>(src.channels)),
        gamma_("gamma", {src.channels}, 0, T(1), false),
        beta_("beta", {src.channels}, 0, T(0), false),
        running_mean_{"running_mean", T(0), std::vector<T>(channels_, T(0))},
        running_variance_{"running_variance", T(1), std::vector<T>(channels_, T(1))},
        mean_(channels_),
        inverse_deviation_(channels_),
        scale_(channels_),
        shift_(channels_) {}

  std::string text() const override { return "batchnorm"; }
  long long flops() const override { return 2LL * this->src_shape().size(); }

  void plan(int batch, Mode mode) override {
    if (mode == Mode::training) parts_.reserve(Tensor<T>::blocks_of(batch) * channels_ * 2);
  }

  void forward(const Tensor<T>& src, const Tensor<T>& dst, Mode mode) override {
    if (mode == Mode::training)
      take_batch_statistics(src);
    else
      for (std::size_t c = 0; c < channels_; ++c)
        set_affine(c, static_cast<double>(running_mean_.value[c]), static_cast<double>(running_variance_.value[c]));
    for_each_group(src.blocks(), this->src_shape().channels, plane_group, [&](int block, int first, int last) {
      for (int c = first; c < last; ++c)
        kernels<T>().batchnorm_apply(const_plane_of(src, block, c), scale_[static_cast<std::size_t>(c)],
                                     shift_[static_cast<std::size_t>(c)], plane_of(dst, block, c));
    });
  }

  void backward(const Tensor<T>& src, const Tensor<T>&, const Tensor<T>& diff_dst, const Tensor<T>* diff_src) override {
    for_each_group(src.blocks(), this->src_shape().channels, plane_group, [&](int block, int first, int last) {
      for (int c = first; c < last; ++c)
        kernels<T>().batchnorm_backward_sums(const_plane_of(src, block, c), const_plane_of(diff_dst, block, c),
                                             static_cast<T>(mean_[static_cast<std::size_t>(c)]), src.valid_lanes(block),
                                             part(block, c));
    });
    tree_sum(parts_.data(), src.blocks(), channels_ * 2);
    // diff_src = gamma/d (diff_dst - mean(diff_dst) - x^ mean(diff_dst x^)), x^ = (src - mean)/d, as a diff_dst + b src
    // + c.
    const double count = values_a_channel(src);
    for (std::size_t c = 0; c < channels_; ++c) {
      const double inverse = inverse_deviation_[c], sum = parts_.data()[2 * c],
                   dot = parts_.data()[2 * c + 1] * inverse;
      gamma_.gradient[c] = static_cast<T>(dot);
      beta_.gradient[c] = static_cast<T>(sum);
      const double a = static_cast<double>(gamma_.value[c]) * inverse;
      const double b = -a * inverse * (dot / count);
      scale_[c] = static_cast<T>(a);
      slope_[c] = static_cast<T>(b);
      shift_[c] = static_cast<T>(-a * (sum / count) - b * static_cast<double>(static_cast<T>(mean_[c])));
    }
    if (diff_src == nullptr) return;
    for_each_group(src.blocks(), this->src_shape().channels, plane_group, [&](int block, int first, int last) {
      for (int c = first; c < last; ++c) {
        const auto k = static_cast<std::size_t>(c);
        kernels<T>().batchnorm_backward_apply(const_plane_of(src, block, c), const_plane_of(diff_dst, block, c),
                                              scale_[k], slope_[k], shift_[k], plane_of(*diff_src, block, c));
      }
    });
  }

  std::vector<Parameter<T>*> parameters() override { return {&gamma_, &beta_}; }
  std::vector<Statistic<T>*> statistics() override { return {&running_mean_, &running_variance_}; }

 private:
  double* part(int block, int channel) {
    return parts_.data() + (static_cast<std::size_t>(block) * channels_ + static_cast<std::size_t>(channel)) * 2;
  }
  double values_a_channel(const Tensor<T>& src) const {
    return static_cast<double>(src.batch()) * this->src_shape().rows * this->src_shape().columns;
  }

  void take_batch_statistics(const Tensor<T>& src) {
    for_each_group(src.blocks(), this->src_shape().channels, plane_group, [&](int block, int first, int last) {
      for (int c = first; c < last; ++c)
        kernels<T>().batchnorm_sums(const_plane_of(src, block, c), running_mean_.value[static_cast<std::size_t>(c)],
                                    src.valid_lanes(block), part(block, c));
    });
    tree_sum(parts_.data(), src.blocks(), channels_ * 2);
    const double count = values_a_channel(src);
    for (std::size_t c = 0; c < channels_; ++c) {
      const double shifted = parts_.data()[2 * c] / count;
      const double mean = static_cast<double>(running_mean_.value[c]) + shifted;
      const double variance = std::max(parts_.data()[2 * c + 1] / count - shifted * shifted, 0.0);
      set_affine(c, mean, variance);
      const double unbiased = count > 1 ? variance * (count / (count - 1)) : variance;
      running_mean_.value[c] =
          static_cast<T>((1 - momentum) * static_cast<double>(running_mean_.value[c]) + momentum * mean);
      running_variance_.value[c] =
          static_cast<T>((1 - momentum) * static_cast<double>(running_variance_.value[c]) + momentum * unbiased);
    }
  }

  void set_affine(std::size_t c, double mean, double variance) {
    mean_[c] = mean;
    inverse_deviation_[c] = 1 / std::sqrt(variance + epsilon);
    const double scale = static_cast<double>(gamma_.value[c]) * inverse_deviation_[c];
    scale_[c] = static_cast<T>(scale);
    shift_[c] = static_cast<T>(static_cast<double>(beta_.value[c]) - mean * scale);
  }

  std::size_t channels_;
  Parameter<T> gamma_, beta_;
  Statistic<T> running_mean_, running_variance_;
  std::vector<double> mean_, inverse_deviation_;      // of the last batch
  std::vector<T> scale_, shift_;                      // forward: y = scale x + shift; backward: factors a and c
  std::vector<T> slope_ = std::vector<T>(channels_);  // backward: factor b
  AlignedBuffer<double> parts_;                       // two sums a block and channel
};

}  // namespace

template <class T>
std::unique_ptr<Layer<T>> make_batchnorm(Shape src, Words&) {
  return std::make_unique<BatchNorm<T>>(src);
}

template std::unique_ptr<Layer<float>> make_batchnorm(Shape, Words&);
template std::unique_ptr<Layer<double>> make_batchnorm(Shape, Words&);

}  // namespace decid::nn
