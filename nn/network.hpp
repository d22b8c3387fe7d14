// A network: a chain of layers made from a text, that is its weights and running statistics and nothing else. A Trainer
// (nn/training/trainer.hpp) changes them; a Predictor (nn/predictor.hpp) runs them; files hold them
// (nn/safetensors.hpp).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "nn/layers/layer.hpp"

namespace decid::nn {

/// A value: copies have weights of their own, and a const Network cannot change.
template <class T = float>
class Network {
 public:
  /// `architecture`: a layer a line, or separated by ';'; a comment from # to the line's end (see make_layers). Throws
  /// Error naming the line that is wrong.
  Network(Shape input, const std::string& architecture);

  const Shape& input_shape() const { return input_shape_; }
  Shape output_shape() const { return layers_.back().dst_shape(); }
  /// The canonical text: complete lines, joined by "\n".
  std::string architecture() const;
  std::span<Layer<T>> layers() { return layers_; }
  std::span<const Layer<T>> layers() const { return layers_; }
  /// All trained tensors, in order of the layers. They stay where they are while the network is moved.
  std::vector<Parameter<T>*> parameters();
  std::vector<const Parameter<T>*> parameters() const;
  /// Trained values.
  std::size_t parameter_count() const;
  /// Of a forward pass of one sample.
  long long flops() const;

  /// He's initialisation (Delving deep into rectifiers, ICCV 2015): weights normal with variance 2 / fan_in, from
  /// (seed, Stream::weights, number of the tensor); biases 0, BatchNorm's gamma 1 and beta 0, its running mean 0 and
  /// variance 1.
  void initialise(std::uint64_t seed);

 private:
  Shape input_shape_;
  std::vector<Layer<T>> layers_;
};

/// SHA-256 over names, shapes and values (float32, little-endian) of all parameters and running statistics.
std::string weights_sha256(const Network<float>& network);

}  // namespace decid::nn
