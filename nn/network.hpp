// A network: a chain of layers made from a text, its memory planned once, forward and backward over a batch.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "nn/layer.hpp"

namespace decid::nn {

template <class T>
class Network {
 public:
  /// `architecture`: a layer a line, or separated by ';' (see make_layers). Throws Error naming the line that is wrong.
  Network(Shape input, const std::string& architecture);

  const Shape& input_shape() const { return input_shape_; }
  const Shape& output_shape() const { return layers_.back()->dst_shape(); }
  /// The canonical text: complete lines, joined by "\n".
  std::string architecture() const;
  const std::vector<std::unique_ptr<Layer<T>>>& layers() const { return layers_; }
  /// All trained tensors, in order of the layers.
  const std::vector<Parameter<T>*>& parameters() const { return parameters_; }
  std::size_t parameter_count() const;
  /// Of a forward pass of one sample.
  long long flops() const;

  /// He's initialisation (Delving deep into rectifiers, ICCV 2015): weights normal with variance 2 / fan_in, from
  /// (seed, Stream::weights, number of the tensor); biases 0, BatchNorm 1 and 0, its running mean 0 and
  /// variance 1; momentum 0.
  void initialise(std::uint64_t seed);

  /// Takes all memory for steps of up to `batch` samples. Nothing allocates afterwards. For inference the weights are
  /// taken as they are: BatchNorm becomes part of the convolution before it, w' = w scale, b' = fma(b, scale, shift).
  void plan(int batch, Mode mode);
  std::size_t planned_bytes() const { return memory_.size() * sizeof(T); }
  int planned_batch() const { return planned_batch_; }
  Mode mode() const { return mode_; }
  /// Samples of the next forward, 1 .. planned_batch().
  void set_batch(int batch);

  /// Where to load the samples.
  const Tensor<T>& input() const { return activations_.front(); }
  const Tensor<T>& output() const { return activations_.back(); }
  /// Where to put d loss / d output before backward (training only).
  const Tensor<T>& output_diff() const { return differences_.back(); }
  void forward();
  /// For looking into a network in inference: runs the loaded samples around `sample` up to layer `layer` (an index of
  /// layers()) and copies that layer's output of `sample`, dst_shape().size() values, channel-major. As BatchNorm is
  /// part of the convolution before it, that convolution's output is the normalised one, before its ReLU. output() is
  /// void afterwards. Throws Error if the network is not planned for inference, or there is no such layer or sample.
  void activation(std::size_t layer, int sample, std::span<T> values);
  /// Gradients of all parameters from output_diff(); overwrites it.
  void backward();

 private:
  void infer();
  /// Samples first .. first + count - 1 through the first `layers` layers; their output.
  Tensor<T> infer_part(int first, int count, std::size_t layers);
  bool whole(std::size_t activation) const;
  bool reuses_source(std::size_t layer) const { return layers_[layer]->in_place(); }
  int activation_halo(std::size_t index) const;
  int difference_halo(std::size_t index) const;
  bool difference_replaces_activation(std::size_t index) const;
  void fold();

  Shape input_shape_;
  std::vector<std::unique_ptr<Layer<T>>> layers_;
  std::vector<Parameter<T>*> parameters_;
  Mode mode_ = Mode::inference;
  int planned_batch_ = 0;
  int batch_ = 0;
  int at_once_ =
      0;  // samples that go through the network together: all in training, so many that stay in the cache else
  AlignedBuffer<T> memory_;
  std::vector<Tensor<T>> activations_;  // [0] the input, [i + 1] the output of layer i
  std::vector<Tensor<T>> differences_;  // the loss's derivative by each of them; empty in inference
};

struct SgdSettings {
  double momentum = 0.9;
  double weight_decay = 1e-4;  ///< L2, on weights only
};

/// Stochastic gradient descent with momentum, one step from the gradients in place:
/// v = momentum v + (gradient + weight_decay w), w = w - rate v.
template <class T>
void sgd_step(const Network<T>& network, double learning_rate, const SgdSettings& settings);

/// SHA-256 over names, shapes and values (float32, little-endian) of all parameters and running statistics.
std::string weights_sha256(const Network<float>& network);

}  // namespace decid::nn
