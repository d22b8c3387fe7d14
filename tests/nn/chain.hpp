// Test helper: layers run one by one, every tensor in memory of its own, where Network shares and plans.
// The plain way that the derivatives of layers, and Network's memory plan, are tested against.
#pragma once

#include <omp.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "nn/layer.hpp"

namespace decid::nn::testing {

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
void load_batch(const Tensor<T>& tensor, std::span<const T> values) {
  const auto size = static_cast<std::size_t>(tensor.shape().size());
  for (int n = 0; n < tensor.batch(); ++n) tensor.load(n, values.subspan(static_cast<std::size_t>(n) * size, size));
}
template <class T>
std::vector<T> store_batch(const Tensor<T>& tensor) {
  const auto size = static_cast<std::size_t>(tensor.shape().size());
  std::vector<T> values(size * static_cast<std::size_t>(tensor.batch()));
  for (int n = 0; n < tensor.batch(); ++n)
    tensor.store(n, std::span(values).subspan(static_cast<std::size_t>(n) * size, size));
  return values;
}

/// Puts `value` wherever a tensor has no sample: the lanes that nothing may read.
template <class T>
void fill_unused_lanes(const Tensor<T>& tensor, T value) {
  const int block = tensor.blocks() - 1;
  const Shape& s = tensor.shape();
  for (int l = tensor.valid_lanes(block); l < lanes; ++l)
    for (int c = 0; c < s.channels; ++c)
      for (int r = 0; r < s.rows; ++r)
        for (int j = 0; j < s.columns; ++j) tensor.row(block, c, r)[j * lanes + l] = value;
}

template <class T>
class Chain {
 public:
  /// A layer a line, lines separated by ';'.
  Chain(Shape input, const std::string& architecture, int batch) {
    std::istringstream stream(architecture);
    for (std::string line; std::getline(stream, line, ';');) {
      layers_.push_back(make_layer<T>(input, line));
      input = layers_.back()->dst_shape();
    }
    plan(batch);
  }

  const std::vector<std::unique_ptr<Layer<T>>>& layers() const { return layers_; }
  /// [0] the input, [i + 1] the output of layer i; the same memory where the layer works in place.
  const std::vector<Tensor<T>>& activations() const { return activations_; }
  const Tensor<T>& input() const { return activations_.front(); }
  const Tensor<T>& output() const { return activations_.back(); }
  const Tensor<T>& input_diff() const { return differences_.front(); }
  const Tensor<T>& output_diff() const { return differences_.back(); }
  std::vector<Parameter<T>*> parameters() const {
    std::vector<Parameter<T>*> all;
    for (const auto& layer : layers_)
      for (Parameter<T>* p : layer->parameters()) all.push_back(p);
    return all;
  }
  std::vector<Statistic<T>*> statistics() const {
    std::vector<Statistic<T>*> all;
    for (const auto& layer : layers_)
      for (Statistic<T>* s : layer->statistics()) all.push_back(s);
    return all;
  }

  void forward(Mode mode) {
    for (std::size_t i = 0; i < layers_.size(); ++i) layers_[i]->forward(activations_[i], activations_[i + 1], mode);
  }
  /// From output_diff(); unlike Network's, down to input_diff().
  void backward() {
    for (std::size_t i = layers_.size(); i-- > 0;)
      layers_[i]->backward(activations_[i], activations_[i + 1], differences_[i + 1], &differences_[i]);
  }

 private:
  Tensor<T> fresh(Shape shape, int batch, int halo) {
    memory_.push_back(std::make_unique<AlignedBuffer<T>>());
    memory_.back()->reserve(Tensor<T>::required(shape, batch, halo));
    return Tensor<T>(memory_.back()->data(), shape, batch, halo);
  }
  void plan(int batch) {
    const std::size_t count = layers_.size();
    for (const auto& layer : layers_) layer->plan(batch, Mode::training);
    differences_.resize(count + 1);
    for (std::size_t i = 0; i <= count; ++i) {
      if (i > 0 && layers_[i - 1]->in_place()) {
        activations_.push_back(activations_.back());
        differences_[i] = differences_[i - 1];
        continue;
      }
      std::size_t reader = i;
      while (reader < count && layers_[reader]->in_place()) ++reader;
      const Shape shape = i == 0 ? layers_[0]->src_shape() : layers_[i - 1]->dst_shape();
      activations_.push_back(fresh(shape, batch, reader < count ? layers_[reader]->src_halo() : 0));
      differences_[i] = fresh(shape, batch, i == 0 ? 0 : layers_[i - 1]->diff_dst_halo());
    }
  }

  std::vector<std::unique_ptr<Layer<T>>> layers_;
  std::vector<std::unique_ptr<AlignedBuffer<T>>> memory_;
  std::vector<Tensor<T>> activations_, differences_;
};

/// For thousands of tiny passes: waking a second thread for each takes longer than the work.
struct OneThread {
  OneThread() { omp_set_num_threads(1); }
  ~OneThread() { omp_set_num_threads(threads); }
  int threads = omp_get_max_threads();
};

/// The problem of the Error that `action` throws, after "where: "; "none" if it throws nothing.
template <class Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.where() + ": " + error.problem();
  }
  return "none";
}

}  // namespace decid::nn::testing
