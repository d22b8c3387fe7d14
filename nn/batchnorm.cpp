// Batch normalisation of each channel: y = gamma (x - mean) / sqrt(variance + epsilon) + beta, with the ReLU and the
// pool that follow it: Ioffe and Szegedy, "Batch normalization", ICML 2015. The batch statistics are sums in double
// around a pivot, the running mean: one pass, and no cancellation once the running mean is near the mean.
//
// The layer keeps nothing but its input. What lies between is made again in backward, a band of rows at a time that
// stays in the first-level cache: memory is what bounds this layer, and arithmetic in the cache is nearly free. After a
// convolution the sums of forward are taken as it writes; and if that is the network's first layer, the derivative by
// its output goes band by band into its weight gradient, and never to memory.
#include <omp.h>

#include <algorithm>
#include <cmath>

#include "nn/layers.hpp"
#include "nn/sharing.hpp"

namespace decid::nn {
namespace {

/// Rows of one plane that are pooled into one row of output.
template <class T>
struct Band {
  Plane<const T> src;
  int dst_row;
};

/// Scratch of the calling thread, for the derivatives of a band. Grows in plan(), or in a thread's first step.
template <class T>
AlignedBuffer<T>& band_scratch() {
  thread_local AlignedBuffer<T> buffer;
  return buffer;
}

template <class T>
class BatchNorm final : public Layer<T>, public Follower<T> {
 public:
  static constexpr double epsilon = 1e-5;
  static constexpr double momentum = 0.1;  // of the running statistics: new = 0.9 old + 0.1 batch

  BatchNorm(Shape src, bool relu, const std::optional<Pool>& pool)
      : Layer<T>(src, pool ? pool->dst() : src),
        relu_(relu),
        pool_(pool),
        channels_(static_cast<std::size_t>(src.channels)),
        gamma_("gamma", {src.channels}, 0, T(1), false),
        beta_("beta", {src.channels}, 0, T(0), false),
        running_mean_{"running_mean", T(0), std::vector<T>(channels_, T(0))},
        running_variance_{"running_variance", T(1), std::vector<T>(channels_, T(1)), true},
        mean_(channels_),
        inverse_deviation_(channels_),
        scale_(channels_),
        shift_(channels_),
        back_(channels_) {}

  std::string text() const override {
    return std::string("batchnorm") + (relu_ ? "\nrelu" : "") + (pool_ ? "\n" + pool_->text() : "");
  }
  long long flops() const override {
    const long long pooled =
        pool_ ? 1LL * this->dst_shape().size() * pool_->shape.kernel_rows * pool_->shape.kernel_columns : 0;
    return (relu_ ? 3LL : 2LL) * this->src_shape().size() + pooled;
  }
  bool diff_may_replace_src() const override { return true; }

  void plan(int batch, Mode mode) override {
    follows_ = false;
    if (mode == Mode::training) parts_.reserve(Tensor<T>::blocks_of(batch) * channels_ * 2);
    const std::size_t values = band_values();
#pragma omp parallel
    band_scratch<T>().reserve(values);
  }

  Follower<T>* follower() override {
    return this;
  }
  void follow() override {
    follows_ = true;
  }
  void add_rows(Plane<const T> rows, int channel, double* sums) const override {
    kernels<T>().batchnorm_sums(rows, running_mean_.value[static_cast<std::size_t>(channel)], sums);
  }
  void keep_sums(const double* sums, int valid, int block, int channel) override {
    double* part =
        parts_.data() + (static_cast<std::size_t>(block) * channels_ + static_cast<std::size_t>(channel)) * 2;
    part[0] = lane_sum(sums, valid);
    part[1] = lane_sum(sums + lanes, valid);
  }

  void forward(const Tensor<T>& src, const Tensor<T>& dst, Mode mode) override {
    if (mode == Mode::training)
      take_batch_statistics(src);
    else
      take_running_statistics();
    for_each_plane(src, [&](int block, int c) {
      kernels<T>().activation_forward(activation(c), pool_ ? pool_->shape : PoolShape{}, const_plane_of(src, block, c),
                                      plane_of(dst, block, c));
    });
  }

  void backward(const Tensor<T>& src, const Tensor<T>&, const Tensor<T>& diff_dst, const Tensor<T>* diff_src) override {
    for_each_plane(src, [&](int block, int c) {
      double sums[2 * lanes] = {};
      for_each_band(const_plane_of(src, block, c), [&](const Band<T>& band) {
        kernels<T>().batchnorm_backward_sums(band.src, band_diff(band, diff_dst, block, c, true), pivot_of(c), sums);
      });
      keep_sums(sums, src.valid_lanes(block), block, c);
    });
    tree_sum(parts_.data(), src.blocks(), channels_ * 2, channels_ * 2);
    // diff_src = gamma/d (dy - mean(dy) - x^ mean(dy x^)), x^ = (src - mean)/d, as a dy + b src + c.
    const double count = values_a_channel(src);
    for (std::size_t c = 0; c < channels_; ++c) {
      const double inverse = inverse_deviation_[c], sum = parts_.data()[2 * c],
                   dot = parts_.data()[2 * c + 1] * inverse;
      gamma_.gradient[c] = static_cast<T>(dot);
      beta_.gradient[c] = static_cast<T>(sum);
      const double a = static_cast<double>(gamma_.value[c]) * inverse;
      const double b = -a * inverse * (dot / count);
      back_[c] = {static_cast<T>(a), static_cast<T>(b),
                  static_cast<T>(-a * (sum / count) - b * static_cast<double>(pivot_of(static_cast<int>(c))))};
    }
    src_ = src;
    diff_dst_ = diff_dst;
    if (diff_src == nullptr) return;
    for_each_plane(src, [&](int block, int c) {
      for (int i = 0; i < bands(); ++i)
        derivative(block, c, i, rows_of(plane_of(*diff_src, block, c), band_begin(i), band_end(i) - band_begin(i)));
    });
  }
  int bands() const override {
    return pool_ ? pool_->shape.dst_rows : (this->src_shape().rows + rows_without_pool - 1) / rows_without_pool;
  }
  int band_end(int band) const override {
    return band + 1 < bands() ? band_begin(band + 1) : this->src_shape().rows;
  }
  void derivative(int block, int channel, int band, Plane<T> diff) const override {
    const Band<T> rows = band_of_plane(const_plane_of(src_, block, channel), band);
    const Factors& f = back_[static_cast<std::size_t>(channel)];
    kernels<T>().batchnorm_backward_apply(rows.src, band_diff(rows, diff_dst_, block, channel, false), f.a, f.b, f.c,
                                          diff);
  }

  Affine<T> take_affine(bool folded) override {
    folded_ = false;
    take_running_statistics();
    const Affine<T> affine{scale_, shift_};
    folded_ = folded;
    return affine;
  }
  Stage<T> stage() const override {
    Stage<T> stage;
    if (!folded_) stage.affine = {scale_, shift_};
    stage.relu = relu_;
    stage.pool = pool_ ? &*pool_ : nullptr;
    return stage;
  }

  std::vector<Parameter<T>*> parameters() override {
    return {&gamma_, &beta_};
  }
  std::vector<Statistic<T>*> statistics() override {
    return {&running_mean_, &running_variance_};
  }

 private:
  static constexpr int rows_without_pool = 4;

  struct Factors {
    T a, b, c;
  };

  template <class Body>
  void for_each_plane(const Tensor<T>& src, const Body& body) const {
    for_each_group(src.blocks(), this->src_shape().channels, plane_group, [&](int block, int first, int last) {
      for (int c = first; c < last; ++c) body(block, c);
    });
  }

  /// With a pool, the rows of one row of windows, the last band taking what is left over; without, a few rows.
  int band_begin(int band) const {
    return band * (pool_ ? pool_->shape.stride_rows : rows_without_pool);
  }
  Band<T> band_of_plane(Plane<const T> plane, int band) const {
    const int first = band_begin(band);
    return {{plane.data + first * plane.row, plane.row, band_end(band) - first, plane.columns}, pool_ ? band : first};
  }
  template <class Body>
  void for_each_band(Plane<const T> plane, const Body& body) const {
    for (int i = 0; i < bands(); ++i) body(band_of_plane(plane, i));
  }
  std::size_t band_values() const {
    int rows = rows_without_pool;
    if (pool_) {
      const PoolShape& s = pool_->shape;
      rows = std::max(s.stride_rows, s.src_rows - (s.dst_rows - 1) * s.stride_rows);
    }
    return static_cast<std::size_t>(rows) * static_cast<std::size_t>(this->src_shape().columns) * lanes;
  }
  Plane<T> scratch_plane(const Plane<const T>& like) const {
    AlignedBuffer<T>& scratch = band_scratch<T>();
    scratch.reserve(band_values());  // does nothing but in a thread that came after plan()
    return {scratch.data(), static_cast<std::ptrdiff_t>(like.columns) * lanes, like.rows, like.columns};
  }
  static Plane<T> rows_of(Plane<T> plane, int first, int rows) {
    return {plane.data + first * plane.row, plane.row, rows, plane.columns};
  }
  static Plane<const T> constant(const Plane<T>& p) {
    return {p.data, p.row, p.rows, p.columns};
  }
  PoolShape pool_shape(const Band<T>& band) const {
    PoolShape s = pool_->shape;
    s.channels = 1;
    s.src_rows = band.src.rows;
    s.dst_rows = 1;
    return s;
  }

  Activation<T> activation(int channel) const {
    const auto c = static_cast<std::size_t>(channel);
    const Pooling pooling = !pool_ ? Pooling::none : pool_->kind == Pool::Kind::max ? Pooling::max : Pooling::average;
    return {scale_[c], shift_[c], relu_, pooling};
  }

  /// The derivative by the normalised values of a band. Without a pool that is diff_dst itself, which ReLU masks where
  /// it stands, once.
  Plane<const T> band_diff(const Band<T>& band, const Tensor<T>& diff_dst, int block, int channel,
                           bool first_time) const {
    const Plane<T> dy = rows_of(plane_of(diff_dst, block, channel), band.dst_row, pool_ ? 1 : band.src.rows);
    const Plane<T> diff = pool_ ? scratch_plane(band.src) : dy;
    if (pool_ || (relu_ && first_time))
      kernels<T>().activation_backward(activation(channel), pool_ ? pool_shape(band) : PoolShape{}, band.src,
                                       constant(dy), diff);
    return constant(diff);
  }

  /// What the sums of both directions are taken around.
  T pivot_of(int channel) const {
    return static_cast<T>(mean_[static_cast<std::size_t>(channel)]);
  }
  double values_a_channel(const Tensor<T>& src) const {
    return static_cast<double>(src.batch()) * this->src_shape().rows * this->src_shape().columns;
  }

  void take_running_statistics() {
    for (std::size_t c = 0; c < channels_; ++c) {
      if (folded_) {
        scale_[c] = T(1);
        shift_[c] = T(0);
      } else {
        set_affine(c, static_cast<double>(running_mean_.value[c]), static_cast<double>(running_variance_.value[c]));
      }
    }
  }

  void take_batch_statistics(const Tensor<T>& src) {
    if (!follows_)
      for_each_plane(src, [&](int block, int c) {
        double sums[2 * lanes] = {};
        add_rows(const_plane_of(src, block, c), c, sums);
        keep_sums(sums, src.valid_lanes(block), block, c);
      });
    tree_sum(parts_.data(), src.blocks(), channels_ * 2, channels_ * 2);
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

  bool relu_;
  bool folded_ = false;  // in inference the layer before does what is affine here
  std::optional<Pool> pool_;
  std::size_t channels_;
  Parameter<T> gamma_, beta_;
  Statistic<T> running_mean_, running_variance_;
  std::vector<double> mean_, inverse_deviation_;  // of the last batch
  std::vector<T> scale_, shift_;                  // y = scale x + shift
  std::vector<Factors> back_;
  bool follows_ = false;         // the convolution before has kept the sums of forward
  Tensor<T> src_, diff_dst_;     // of the last backward, for derivative()
  AlignedBuffer<double> parts_;  // two sums a block and channel
};

}  // namespace

template <class T>
std::unique_ptr<Layer<T>> make_batchnorm(Shape src, bool relu, const std::optional<Pool>& pool) {
  return std::make_unique<BatchNorm<T>>(src, relu, pool);
}

template std::unique_ptr<Layer<float>> make_batchnorm(Shape, bool, const std::optional<Pool>&);
template std::unique_ptr<Layer<double>> make_batchnorm(Shape, bool, const std::optional<Pool>&);

}  // namespace decid::nn
