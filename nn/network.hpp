// A network: a chain of layers made from a text. It holds only weights and running statistics. A Trainer
// (nn/training/trainer.hpp) changes them; a Predictor (nn/predictor.hpp) runs them; files hold them
// (nn/safetensors.hpp).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "nn/layers/layer.hpp"

namespace decid::nn {

/// A network with value semantics: copies have their own weights, and a const Network cannot change. Many threads may
/// read one network at once. While one thread changes it, no other may use it.
template <class T = float>
class Network {
 public:
  /// `architecture`: one layer per line, or layers separated by ';'; comments go from # to the line's end (see
  /// parse_layers). All weights are 0 until initialise() or nn::fit(). Throws Error naming the line that is wrong.
  Network(Shape input, const std::string& architecture);

  const Shape& input_shape() const { return input_shape_; }
  Shape output_shape() const { return layers_.back().dst_shape(); }
  /// Returns the canonical text: complete lines, joined by "\n".
  std::string architecture() const;
  std::span<Layer<T>> layers() { return layers_; }
  std::span<const Layer<T>> layers() const { return layers_; }
  /// Returns all trained tensors, in order of the layers. They stay where they are while the network is moved.
  std::vector<Parameter<T>*> parameters();
  std::vector<const Parameter<T>*> parameters() const;
  /// Returns the number of trained values.
  std::size_t parameter_count() const;
  /// Returns the floating-point operations of a forward pass of one sample.
  long long flops() const;

  /// Initialises the weights by He's method (Delving deep into rectifiers, ICCV 2015): weights normal with variance 2 /
  /// fan_in, from (seed, Stream::weights, number of the tensor); biases 0, BatchNorm's gamma 1 and beta 0, its running
  /// mean 0 and variance 1.
  void initialise(std::uint64_t seed);

 private:
  Shape input_shape_;
  std::vector<Layer<T>> layers_;
};

/// Returns the number of trained values that such a network has, without the memory for them. Throws Error as its
/// constructor does.
std::size_t parameter_count(Shape input, const std::string& architecture);

/// Returns the SHA-256 over names, shapes and values (float32, little-endian) of all parameters and running statistics.
std::string weights_sha256(const Network<float>& network);

}  // namespace decid::nn
