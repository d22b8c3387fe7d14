// Batch normalisation, with the ReLU and the pool that are fused with it (nn/layers/layer.hpp). In training the batch
// statistics are sums in double around a pivot, the running mean: one pass, and no cancellation once the running mean
// is near the mean.
//
// The layer keeps only its input. Backward recomputes the intermediate values, a band of rows at a time that stays in
// the first-level cache. Memory bandwidth limits this layer, and arithmetic in the cache is nearly free.
#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "base/per_thread.hpp"
#include "nn/detail/forward.hpp"
#include "nn/layers/detail/layers.hpp"
#include "nn/layers/detail/normalisation.hpp"
#include "nn/layers/detail/training_layers.hpp"

namespace decid::nn {

LayerKind parse_batchnorm(Shape src, Words&) {
  return BatchNorm{src, false, std::nullopt};
}

bool fuse_with_batchnorm(LayerKind& before, const LayerKind& next) {
  auto* const norm = std::get_if<BatchNorm>(&before);
  if (norm == nullptr || norm->pool) return false;
  if (std::holds_alternative<Relu>(next) && !norm->relu) return norm->relu = true;
  if (const auto* pool = std::get_if<Pool>(&next); pool != nullptr && !pool->overlaps()) norm->pool = *pool;
  return norm->pool.has_value();
}

std::string BatchNorm::text() const {
  return std::string("batchnorm") + (relu ? "\nrelu" : "") + (pool ? "\n" + pool->text() : "");
}

namespace {

/// Rows of one plane that are pooled into one row of output.
template <class T>
struct Band {
  Plane<const T> src;
  int src_row, dst_row;
};

/// Scratch of the calling thread, for the derivatives of a band. Grows in a constructor, or in a thread's first step.
template <class T>
AlignedBuffer<T>& band_scratch() {
  struct Scratch {
    AlignedBuffer<T> buffer;
  };
  return per_thread<Scratch>().buffer;
}

template <class P>
P rows_of(P plane, int first, int rows) {
  return {plane.data + first * plane.row, plane.row, rows, plane.columns};
}

template <class T>
class BatchNormTraining final : public TrainingLayer<T> {
 public:
  BatchNormTraining(Layer<T>& layer, const BatchNorm& norm, int max_batch, TrainingLayer<T>* before)
      : TrainingLayer<T>(layer),
        norm_(norm),
        channels_(static_cast<std::size_t>(norm.shape.channels)),
        mean_(channels_),
        normalisations_(channels_),
        factors_(channels_),
        sums_(layer.statistics()[0], max_batch),
        fused_(before != nullptr && before->fuse(sums_)) {
    if (norm_.pool) in_each_thread([values = band_values()] { band_scratch<T>().reserve(values); });
  }

  bool diff_may_replace_src() const override { return true; }
  void freeze_statistics() override { frozen_ = true; }

  void forward(const TensorView<const T>& src, const TensorView<T>& dst) override {
    frozen_ ? use_running_statistics() : measure_batch(src);
    each_plane(src, [&](int block, int c) {
      kernels<T>().activation_forward(activation(c), norm_.pool ? norm_.pool->shape : PoolShape{}, src.plane(block, c),
                                      dst.plane(block, c));
    });
  }

  void backward(const TensorView<const T>& src, const TensorView<const T>&, const TensorView<T>& diff_dst,
                const TensorView<T>* diff_src) override {
    each_plane(src, [&](int block, int c) {
      double sums[2 * lanes] = {};
      for_each_band(src.plane(block, c), [&](const Band<T>& band) {
        kernels<T>().batchnorm_backward_sums(band.src, band_diff(band, diff_dst.plane(block, c), c, true), pivot_of(c),
                                             sums);
      });
      sums_.keep(sums, src.valid_lanes(block), block, c);
    });
    set_gradients(sums_.total(src.blocks(), this->all_reduce()), values_a_channel(src));
    if (diff_src == nullptr) return;
    each_plane(src, [&](int block, int c) {
      const Factors& f = factors_[static_cast<std::size_t>(c)];
      for_each_band(src.plane(block, c), [&](const Band<T>& band) {
        kernels<T>().batchnorm_backward_apply(band.src, band_diff(band, diff_dst.plane(block, c), c, false), f.a, f.b,
                                              f.c, rows_of(diff_src->plane(block, c), band.src_row, band.src.rows));
      });
    });
  }

 private:
  /// Four, or as many as have 256 columns, 16 KB.
  int rows_without_pool() const { return std::max(4, 256 / norm_.shape.columns); }

  /// diff_src = a dy + b src + c.
  struct Factors {
    T a, b, c;
  };

  template <class Body>
  void each_plane(const TensorView<const T>& src, const Body& body) const {
    for_each_plane(src.blocks(), norm_.shape.channels, body);
  }

  /// With a pool, the rows of one row of windows, the last band taking what is left over; without, a few rows.
  template <class Body>
  void for_each_band(Plane<const T> plane, const Body& body) const {
    const int step = norm_.pool ? norm_.pool->shape.stride_rows : rows_without_pool();
    const int bands = norm_.pool ? norm_.pool->shape.dst_rows : (plane.rows + step - 1) / step;
    for (int i = 0; i < bands; ++i) {
      const int row = i * step, end = i + 1 < bands ? row + step : plane.rows;
      body(Band<T>{rows_of(plane, row, end - row), row, norm_.pool ? i : row});
    }
  }
  /// The values of the largest band of a layer with a pool.
  std::size_t band_values() const {
    const PoolShape& s = norm_.pool->shape;
    const int rows = std::max(s.stride_rows, s.src_rows - (s.dst_rows - 1) * s.stride_rows);
    return static_cast<std::size_t>(rows) * static_cast<std::size_t>(norm_.shape.columns) * lanes;
  }
  Plane<T> scratch_plane(const Plane<const T>& like) const {
    AlignedBuffer<T>& scratch = band_scratch<T>();
    scratch.reserve(band_values());  // has an effect only in a thread that started after the constructor
    return {scratch.data(), static_cast<std::ptrdiff_t>(like.columns) * lanes, like.rows, like.columns};
  }
  PoolShape pool_shape(const Band<T>& band) const {
    PoolShape s = norm_.pool->shape;
    s.channels = 1;
    s.src_rows = band.src.rows;
    s.dst_rows = 1;
    return s;
  }

  Activation<T> activation(int channel) const {
    const Normalisation& n = normalisations_[static_cast<std::size_t>(channel)];
    return {static_cast<T>(n.scale), static_cast<T>(n.shift), norm_.relu, make_pooling(norm_.pool)};
  }

  /// The derivative by the normalised values of a band. Without a pool that is diff_dst itself, which ReLU masks where
  /// it stands, once.
  Plane<const T> band_diff(const Band<T>& band, Plane<T> diff_dst, int channel, bool first_time) const {
    const Plane<T> dy = rows_of(diff_dst, band.dst_row, norm_.pool ? 1 : band.src.rows);
    const Plane<T> diff = norm_.pool ? scratch_plane(band.src) : dy;
    if (norm_.pool || (norm_.relu && first_time))
      kernels<T>().activation_backward(activation(channel), norm_.pool ? pool_shape(band) : PoolShape{}, band.src, dy,
                                       diff);
    return diff;
  }

  /// Returns the pivot of the sums of backward.
  T pivot_of(int channel) const { return static_cast<T>(mean_[static_cast<std::size_t>(channel)]); }
  double values_a_channel(const TensorView<const T>& src) const {
    const int batch = this->all_reduce() != nullptr ? this->all_reduce()->batch() : src.batch();
    return static_cast<double>(batch) * norm_.shape.rows * norm_.shape.columns;
  }

  /// The batch's mean and variance, by which it is normalised; the running ones move towards them.
  void measure_batch(const TensorView<const T>& src) {
    if (!fused_)
      each_plane(src, [&](int block, int c) {
        double sums[2 * lanes] = {};
        sums_.add_rows(src.plane(block, c), c, sums);
        sums_.keep(sums, src.valid_lanes(block), block, c);
      });
    const double* const total = sums_.total(src.blocks(), this->all_reduce());
    const double count = values_a_channel(src);
    std::vector<T>&running_mean = this->statistic(0), &running_variance = this->statistic(1);
    const auto move = [](T& running, double measured) {
      running =
          static_cast<T>((1 - BatchNorm::momentum) * static_cast<double>(running) + BatchNorm::momentum * measured);
    };
    for (std::size_t c = 0; c < channels_; ++c) {
      const double shifted = total[2 * c] / count;
      mean_[c] = static_cast<double>(running_mean[c]) + shifted;
      const double variance = std::max(total[2 * c + 1] / count - shifted * shifted, 0.0);
      normalisations_[c] = normalisation(static_cast<double>(this->value(0)[c]), static_cast<double>(this->value(1)[c]),
                                         mean_[c], variance);
      move(running_mean[c], mean_[c]);
      move(running_variance[c], count > 1 ? variance * (count / (count - 1)) : variance);
    }
  }

  void use_running_statistics() {
    for (std::size_t c = 0; c < channels_; ++c) {
      mean_[c] = static_cast<double>(this->statistic(0)[c]);
      normalisations_[c] = normalisation(static_cast<double>(this->value(0)[c]), static_cast<double>(this->value(1)[c]),
                                         mean_[c], static_cast<double>(this->statistic(1)[c]));
    }
  }

  /// diff_src = gamma/d (dy - mean(dy) - x^ mean(dy x^)), with x^ = (src - mean)/d and `total` the sums of dy and of
  /// dy (src - mean). Running statistics do not depend on src: diff_src = gamma/d dy.
  void set_gradients(const double* total, double count) {
    for (std::size_t c = 0; c < channels_; ++c) {
      const double inverse = normalisations_[c].inverse_stddev, sum = total[2 * c], dot = total[2 * c + 1] * inverse;
      this->gradient(0)[c] = static_cast<T>(dot);
      this->gradient(1)[c] = static_cast<T>(sum);
      const double a = static_cast<double>(this->value(0)[c]) * inverse;
      if (frozen_) {
        factors_[c] = {static_cast<T>(a), T(0), T(0)};
        continue;
      }
      const double b = -a * inverse * (dot / count);
      factors_[c] = {static_cast<T>(a), static_cast<T>(b),
                     static_cast<T>(-a * (sum / count) - b * static_cast<double>(pivot_of(static_cast<int>(c))))};
    }
  }

  BatchNorm norm_;
  std::size_t channels_;
  std::vector<double> mean_;  // of the last batch, and by what it was normalised
  std::vector<Normalisation> normalisations_;
  std::vector<Factors> factors_;  // of the last backward
  BatchSums<T> sums_;
  bool fused_;  // the convolution before takes the sums of forward
  bool frozen_ = false;
};

}  // namespace

template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const BatchNorm& norm, int max_batch,
                                                TrainingLayer<T>* before) {
  return std::make_unique<BatchNormTraining<T>>(layer, norm, max_batch, before);
}

template std::unique_ptr<TrainingLayer<float>> make_training(Layer<float>&, const BatchNorm&, int,
                                                             TrainingLayer<float>*);
template std::unique_ptr<TrainingLayer<double>> make_training(Layer<double>&, const BatchNorm&, int,
                                                              TrainingLayer<double>*);

}  // namespace decid::nn
