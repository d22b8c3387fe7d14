// Layers run one by one, none fused, every tensor in memory of its own, where a Trainer fuses and shares: the plain way
// that the derivatives of layers, a Trainer's memory plan and the lowering to inference are tested against.
#pragma once

#include <omp.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "nn/architecture.hpp"
#include "nn/layers/training_layer.hpp"
#include "nn/training/batch.hpp"
#include "tests/helpers.hpp"

namespace decid::nn::testing {

using test::check_error;

/// A number in [-1, 1) for (id, index), a multiple of 2^-23: exact in float. tests/nn/torch_figures.py has the same.
inline double hashed(std::uint32_t id, std::size_t index) {
  std::uint32_t h = static_cast<std::uint32_t>(index) * 0x9e3779b9u + id * 0x85ebca6bu + 0x1234567u;
  h = (h ^ (h >> 16)) * 0x7feb352du;  // Chris Wellons' lowbias32
  h = (h ^ (h >> 15)) * 0x846ca68bu;
  h ^= h >> 16;
  return static_cast<double>(h >> 8) * 0x1p-23 - 1.0;
}

template <class T>
std::vector<T> hashed_values(std::uint32_t id, std::size_t count, double scale = 1.0, double offset = 0.0) {
  std::vector<T> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<T>(offset + scale * hashed(id, i));
  return values;
}

/// Batch x sample, as the samples lie one after the other.
template <class T>
void load_batch(const TensorView<T>& tensor, std::span<const std::type_identity_t<T>> values) {
  const auto size = static_cast<std::size_t>(tensor.shape().size());
  for (int n = 0; n < tensor.batch(); ++n) tensor.load(n, values.subspan(static_cast<std::size_t>(n) * size, size));
}
template <class T>
auto store_batch(const TensorView<T>& tensor) {
  const auto size = static_cast<std::size_t>(tensor.shape().size());
  std::vector<std::remove_const_t<T>> values(size * static_cast<std::size_t>(tensor.batch()));
  for (int n = 0; n < tensor.batch(); ++n)
    tensor.store(n, std::span(values).subspan(static_cast<std::size_t>(n) * size, size));
  return values;
}

/// Puts `value` wherever a tensor has no sample: the lanes that nothing may read.
template <class T>
void fill_unused_lanes(const TensorView<T>& tensor, T value) {
  const int block = tensor.blocks() - 1;
  const Shape& s = tensor.shape();
  for (int l = tensor.valid_lanes(block); l < lanes; ++l)
    for (int c = 0; c < s.channels; ++c)
      for (int r = 0; r < s.rows; ++r)
        for (int j = 0; j < s.columns; ++j) tensor.row(block, c, r)[j * lanes + l] = value;
}

/// The layer of a single line.
template <class T>
Layer<T> make_layer(Shape src, const std::string& line) {
  return std::move(make_layers<T>(src, {line}).front());
}

template <class T>
class Chain {
 public:
  /// A layer a line, lines separated by ';'.
  Chain(Shape input, const std::string& architecture, int batch) {
    std::istringstream stream(architecture);
    for (std::string line; std::getline(stream, line, ';');) {
      layers_.push_back(make_layer<T>(input, line));
      input = layers_.back().dst_shape();
    }
    plan(batch);
  }

  const std::vector<Layer<T>>& layers() const { return layers_; }
  /// [0] the input, [i + 1] the output of layer i; the same memory where the layer works in place.
  const std::vector<TensorView<T>>& activations() const { return activations_; }
  const TensorView<T>& input() const { return activations_.front(); }
  const TensorView<T>& output() const { return activations_.back(); }
  const TensorView<T>& input_diff() const { return differences_.front(); }
  const TensorView<T>& output_diff() const { return differences_.back(); }
  std::vector<Parameter<T>*> parameters() {
    std::vector<Parameter<T>*> all;
    for (Layer<T>& layer : layers_)
      for (Parameter<T>& p : layer.parameters()) all.push_back(&p);
    return all;
  }
  std::vector<RunningStatistics<T>*> statistics() {
    std::vector<RunningStatistics<T>*> all;
    for (Layer<T>& layer : layers_)
      for (RunningStatistics<T>& s : layer.statistics()) all.push_back(&s);
    return all;
  }
  /// Returns the gradient of parameters()[parameter].
  const std::vector<T>& gradient(std::size_t parameter) const { return *gradients_.at(parameter); }

  void forward() {
    for (std::size_t i = 0; i < layers_.size(); ++i) training_[i]->forward(activations_[i], activations_[i + 1]);
  }
  /// Runs from output_diff() down to input_diff(), which a Trainer's backward() can omit.
  void backward() {
    for (std::size_t i = layers_.size(); i-- > 0;)
      training_[i]->backward(activations_[i], activations_[i + 1], differences_[i + 1], &differences_[i]);
  }
  /// Runs inference with each layer lowered separately, so that nothing is folded; writes only output().
  void infer() {
    std::vector<T> values = store_batch(input());
    for (const Layer<T>& layer : layers_) {
      const Inference<T> inference(std::span<const Layer<T>>(&layer, 1));
      BatchExecutor<T> executor(inference, input().batch());
      load_batch(executor.input(), values);
      executor.forward();
      values = store_batch(executor.output());
    }
    load_batch(output(), values);
  }

 private:
  TensorView<T> fresh(Shape shape, int batch, Halo halo) {
    memory_.push_back(std::make_unique<AlignedBuffer<T>>());
    memory_.back()->reserve(TensorView<T>::required(shape, batch, halo));
    return TensorView<T>(memory_.back()->data(), shape, batch, halo);
  }
  void plan(int batch) {
    const std::size_t count = layers_.size();
    for (Layer<T>& layer : layers_) {
      training_.push_back(make_training_layer(layer, batch));
      for (std::size_t k = 0; k < layer.parameters().size(); ++k) gradients_.push_back(&training_.back()->gradient(k));
    }
    differences_.resize(count + 1);
    for (std::size_t i = 0; i <= count; ++i) {
      if (i > 0 && training_[i - 1]->in_place()) {
        activations_.push_back(activations_.back());
        differences_[i] = differences_[i - 1];
        continue;
      }
      std::size_t reader = i;
      while (reader < count && training_[reader]->in_place()) ++reader;
      const Shape shape = i == 0 ? layers_[0].src_shape() : layers_[i - 1].dst_shape();
      activations_.push_back(fresh(shape, batch, reader < count ? training_[reader]->src_halo() : Halo{}));
      differences_[i] = fresh(shape, batch, i == 0 ? Halo{} : training_[i - 1]->diff_dst_halo());
    }
  }

  std::vector<Layer<T>> layers_;
  std::vector<std::unique_ptr<TrainingLayer<T>>> training_;
  std::vector<std::vector<T>*> gradients_;
  std::vector<std::unique_ptr<AlignedBuffer<T>>> memory_;
  std::vector<TensorView<T>> activations_, differences_;
};

/// Sets the number of OpenMP's threads until it is destroyed. One for thousands of tiny passes: waking a second thread
/// for each takes longer than the work.
struct Threads {
  explicit Threads(int number) { omp_set_num_threads(number); }
  ~Threads() { omp_set_num_threads(before); }
  int before = omp_get_max_threads();
};

inline bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0);
}

}  // namespace decid::nn::testing
