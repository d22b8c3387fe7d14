// A layer in one file: its line, its shapes, forward and backward. A program registers its own layer; from then on
// every architecture can use the line, in training and inference:
//
//   class Square final : public nn::OperationOf<Square> {
//    public:
//     explicit Square(nn::Shape shape) : OperationOf(shape, shape) {}
//     std::string text() const override { return "square"; }
//     template <class T>
//     void forward_pass(const nn::ForwardPass<T>& pass) const {
//       nn::map<T>(pass.src, pass.dst, [](T x) { return x * x; });
//     }
//     template <class T>
//     void backward_pass(const nn::BackwardPass<T>& pass) const {
//       nn::map_backward<T>(pass, [](T x, T, T dy) { return 2 * x * dy; });
//     }
//   };
//   nn::register_layer("square", [](nn::Shape src, nn::Words&) -> nn::OperationPointer {
//     return std::make_shared<Square>(src);
//   });
//
// For layers with parameters see nn/layers/layernorm.cpp.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/math/random.hpp"
#include "nn/tensor.hpp"
#include "nn/training/sharing.hpp"
#include "nn/words.hpp"

namespace decid::nn {

/// A trained tensor of an operation: see Parameter.
struct OperationParameter {
  std::string name;
  std::vector<int> shape;
  int fan_in = 0;  ///< 0: starts at `initial`, and does not decay
  double initial = 0;
};

/// The random numbers of a step and layer in training.
struct StepRandom {
  const Random* numbers = nullptr;  ///< null: none are drawn, as in inference
  std::span<const int> blocks{};    ///< of the batch, that a process with a part of it has; empty: all

  explicit operator bool() const { return numbers != nullptr; }
  /// Returns the number of one of this process' blocks within the whole batch. Indices count from there, so that
  /// masks do not depend on the number of processes.
  int block(int own) const { return blocks.empty() ? own : blocks[static_cast<std::size_t>(own)]; }
};

template <class T>
struct ForwardPass {
  TensorView<const T> src;
  TensorView<T> dst;
  std::span<const std::span<const T>> parameters;
  StepRandom random;
};

template <class T>
struct BackwardPass {
  TensorView<const T> src, dst, diff_dst;
  const TensorView<T>* diff_src;  ///< null: not needed
  std::span<const std::span<const T>> parameters;
  StepRandom random;              ///< as in forward
  std::span<T* const> gradients;  ///< of each parameter, for each block of 16 samples: see gradient()

  /// Returns the place for the gradient of a parameter over the samples of one block. The blocks are added up
  /// afterwards.
  T* gradient(std::size_t parameter, int block) const {
    return gradients[parameter] + static_cast<std::size_t>(block) * parameters[parameter].size();
  }
};

/// The computation of one line of an architecture. Immutable. Results must not depend on the number of threads, or on
/// the values in lanes without a sample.
class Operation {
 public:
  Operation(Shape src, Shape dst) : src_(src), dst_(dst) {}
  virtual ~Operation() = default;

  const Shape& src() const { return src_; }
  const Shape& dst() const { return dst_; }
  /// Returns the complete line, one word at least, from which the registered parser makes the same operation.
  virtual std::string text() const = 0;
  virtual std::vector<OperationParameter> parameters() const { return {}; }
  virtual long long flops() const { return dst_.size(); }
  /// Returns true if it draws random numbers in training.
  virtual bool is_random() const { return false; }
  /// Returns the zeros that it reads around src, and around diff_dst.
  virtual Halo src_halo() const { return {}; }
  virtual Halo diff_dst_halo() const { return {}; }
  /// Returns false if backward does not read dst. Then a relu behind works in dst, and needs no memory.
  virtual bool backward_reads_dst() const { return true; }

  virtual void forward(const ForwardPass<float>& pass) const = 0;
  virtual void forward(const ForwardPass<double>& pass) const = 0;
  /// Writes the gradients and, unless null, diff_src.
  virtual void backward(const BackwardPass<float>& pass) const = 0;
  virtual void backward(const BackwardPass<double>& pass) const = 0;

 private:
  Shape src_, dst_;
};

/// Own has templates forward_pass<T>(ForwardPass<T>) and backward_pass<T>(BackwardPass<T>), for float and double:
/// checks of gradients need the second.
template <class Own>
class OperationOf : public Operation {
 public:
  using Operation::Operation;
  void forward(const ForwardPass<float>& pass) const override { own().forward_pass(pass); }
  void forward(const ForwardPass<double>& pass) const override { own().forward_pass(pass); }
  void backward(const BackwardPass<float>& pass) const override { own().backward_pass(pass); }
  void backward(const BackwardPass<double>& pass) const override { own().backward_pass(pass); }

 private:
  const Own& own() const { return static_cast<const Own&>(*this); }
};

using OperationPointer = std::shared_ptr<const Operation>;
/// Makes the operation of a line whose first word was taken, for inputs of shape src, which the operation's src() must
/// be. Words throws for arguments that do not fit. An architecture refuses an operation whose text() does not read
/// back.
using OperationParser = OperationPointer (*)(Shape src, Words& words);
/// Registers `parser` for lines that begin with `word`. Throws Error if another parser or decid itself has that word,
/// if it is not one word, or for no parser.
void register_layer(const std::string& word, OperationParser parser);

/// Calls body(place in a, place in b, ...) for every value of tensors of one shape, planes among threads.
template <class Body, class First, class... Others>
void for_each_value(const Body& body, const TensorView<First>& first, const TensorView<Others>&... others) {
  const Shape& s = first.shape();
  for_each_plane(first.blocks(), s.channels, [&](int block, int channel) {
    for (int i = 0; i < s.rows; ++i)
      for (int k = 0; k < s.columns * lanes; ++k)
        body(first.row(block, channel, i) + k, (others.row(block, channel, i) + k)...);
  });
}

/// dst = f(src), value by value.
template <class T, class F>
void map(const TensorView<const T>& src, const TensorView<T>& dst, const F& f) {
  for_each_value([&](const T* x, T* y) { *y = f(*x); }, src, dst);
}

/// diff_src = f(src, dst, diff_dst), value by value.
template <class T, class F>
void map_backward(const BackwardPass<T>& pass, const F& f) {
  if (pass.diff_src != nullptr)
    for_each_value([&](const T* x, const T* y, const T* dy, T* dx) { *dx = f(*x, *y, *dy); }, pass.src, pass.dst,
                   pass.diff_dst, *pass.diff_src);
}

}  // namespace decid::nn
