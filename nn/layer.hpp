// A layer: a forward/backward pair over batches, with its parameters and their gradients. Adding one means one file
// that derives from Layer and a line in make_layers.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "nn/kernels/kernels.hpp"
#include "nn/tensor.hpp"

namespace decid::nn {

struct Pool;

/// training: batch statistics, activations kept for backward. inference: running statistics, nothing kept.
enum class Mode { training, inference };

/// A trained tensor with its gradient and its momentum.
template <class T>
struct Parameter {
  std::string name;        ///< within the layer: "weight", "bias"
  std::vector<int> shape;  ///< as in the file, row-major; convolutions (out, in, rows, columns)
  int fan_in = 0;          ///< inputs of one output, for He's initialisation; 0: starts at `initial`
  T initial = 0;
  bool decays = false;  ///< L2 regularisation applies (weights, not biases or BatchNorm)
  std::vector<T> value, gradient, velocity;

  Parameter(std::string name_, std::vector<int> shape_, int fan_in_, T initial_, bool decays_);
};

/// The most values of a parameter, or of one sample of a tensor: a gigabyte; indices fit an int.
inline constexpr long long most_values = 1LL << 28;

/// A tensor that is measured, not trained: BatchNorm's running mean and variance.
template <class T>
struct Statistic {
  std::string name;
  T initial = 0;
  std::vector<T> value;
  bool never_negative = false;
};

/// scale x + shift, one pair a channel; empty: x.
template <class T>
struct Affine {
  std::vector<T> scale, shift;
};

/// A layer in inference, in the order in which things happen; the pointers are the layer's own.
template <class T>
struct Stage {
  const Conv2dShape* conv = nullptr;  ///< a convolution with these weights, or
  bool fully_connected = false;       ///< all values of the sample to each output; or neither
  const T* weight = nullptr;
  const T* bias = nullptr;
  Affine<T> affine;
  bool relu = false;
  const Pool* pool = nullptr;
};

/// What a BatchNorm does for the convolution before it in training, so that a band of rows is read while it is in the
/// cache. Planes and bands are of the convolution's output.
template <class T>
class Follower {
 public:
  virtual ~Follower() = default;

  /// From the next plan on, forward finds the sums of every plane of src kept.
  virtual void follow() = 0;
  /// Forward: adds rows of a channel to its sums, calls in order of rows; then keeps a plane's.
  virtual void add_rows(Plane<const T> rows, int channel, double* sums) const = 0;
  virtual void keep_sums(const double* sums, int valid, int block, int channel) = 0;

  /// Backward, after its own backward without diff_src: the bands of a plane, each the rows from where the last one
  /// ends to band_end(band), and the derivative by the rows of one.
  virtual int bands() const = 0;
  virtual int band_end(int band) const = 0;
  virtual void derivative(int block, int channel, int band, Plane<T> diff) const = 0;
};

template <class T>
class Layer {
 public:
  explicit Layer(Shape src, Shape dst) : src_shape_(src), dst_shape_(dst) {}
  virtual ~Layer() = default;

  const Shape& src_shape() const { return src_shape_; }
  const Shape& dst_shape() const { return dst_shape_; }
  /// The layer's line in an architecture text, complete: "conv 64 3x3 stride 1x1 pad 1x1"; several, joined by "\n", for
  /// layers that run as one.
  virtual std::string text() const = 0;
  /// Lines of text(). A tensor in a file is named by the line of its layer, so that running layers as one renames none.
  std::size_t lines() const;
  /// Floating-point operations of a forward pass of one sample (a fused multiply-add counts 2).
  virtual long long flops() const = 0;
  /// dst is src's memory, and backward turns diff_dst into diff_src where it stands.
  virtual bool in_place() const { return false; }
  /// diff_src may be src's memory: backward reads each value of src before it writes there.
  virtual bool diff_may_replace_src() const { return false; }
  /// backward reads dst, so that the layer above must leave it alone.
  virtual bool backward_reads_dst() const { return false; }
  /// Zeros this layer reads around src in forward and backward, and around diff_dst in backward.
  virtual int src_halo() const { return 0; }
  virtual int diff_dst_halo() const { return 0; }
  /// Takes the scratch memory that steps of up to `batch` samples need; no later call allocates.
  virtual void plan(int batch, Mode mode) {
    (void)batch;
    (void)mode;
  }

  /// This layer as one that helps the layer before it, or null.
  virtual Follower<T>* follower() { return nullptr; }
  /// Takes the layer after it as helper for training, until the next plan. False if it has no use for one.
  virtual bool lead(Follower<T>& follower) {
    (void)follower;
    return false;
  }
  /// The layer asks its follower for the derivative by dst, as far as backward is called without diff_src; diff_dst is
  /// void then.
  virtual bool asks_follower() const { return false; }

  virtual void forward(const Tensor<T>& src, const Tensor<T>& dst, Mode mode) = 0;
  /// After forward in training mode. Writes the parameters' gradients and, unless null, diff_src.
  virtual void backward(const Tensor<T>& src, const Tensor<T>& dst, const Tensor<T>& diff_dst,
                        const Tensor<T>* diff_src) = 0;

  /// For inference: takes `after` (dst = scale dst + shift, a channel each) into its own weights, which are to stay as
  /// they are from then on; an empty one gives the weights back their own. False if the layer has no weights.
  virtual bool fold(const Affine<T>& after) {
    (void)after;
    return false;
  }
  /// For inference: what this layer does first, as far as it is affine; `folded` says that the layer before does it.
  virtual Affine<T> take_affine(bool folded) {
    (void)folded;
    return {};
  }
  /// What the layer computes in inference, for those who compute it elsewhere.
  virtual Stage<T> stage() const = 0;

  virtual std::vector<Parameter<T>*> parameters() { return {}; }
  virtual std::vector<Statistic<T>*> statistics() { return {}; }

 private:
  Shape src_shape_, dst_shape_;
};

/// After plans for training: every layer that can leads the one after it.
template <class T>
void join(const std::vector<std::unique_ptr<Layer<T>>>& layers) {
  for (std::size_t i = 1; i < layers.size(); ++i)
    if (Follower<T>* const follower = layers[i]->follower(); follower != nullptr && layers[i - 1]->lead(*follower))
      follower->follow();
}
/// Whether backward of a joined layer is called with diff_src: the first has no need of it, nor has the second if the
/// first asks for it band by band.
template <class T>
bool gives_diff_src(const std::vector<std::unique_ptr<Layer<T>>>& layers, std::size_t layer) {
  return layer > 1 || (layer == 1 && !layers[0]->asks_follower());
}

/// The words of a layer's line, read one by one with errors that name the line.
class Words {
 public:
  explicit Words(const std::string& line);

  const std::string& line() const { return line_; }
  bool done() const { return next_ == words_.size(); }
  /// Throws Error if there are words left.
  void finish() const;
  /// The next word. Throws Error if there is none.
  std::string take();
  /// Takes the next word if it is `word`.
  bool take_if(const std::string& word);
  /// A whole number in [low, high].
  int take_int(int low, int high);
  /// "3" or "3x5": rows and columns, each in [low, high].
  std::pair<int, int> take_pair(int low, int high);
  [[noreturn]] void fail(const std::string& problem) const;
  /// Fails if `count` of `what` are more than most_values.
  void limit(long long count, const std::string& what) const;

 private:
  int to_int(const std::string& word, int low, int high) const;
  std::string line_;
  std::vector<std::string> words_;
  std::size_t next_ = 0;
};

/// The layers that an architecture text describes, a layer a line, for inputs of shape `src`:
///   conv CHANNELS ROWSxCOLUMNS [stride RxC] [pad RxC]    batchnorm    relu
///   maxpool RxC [stride RxC]    avgpool RxC [stride RxC]    globalavgpool    fc OUTPUTS
/// batchnorm, relu and pool lines in a row become one layer, which keeps its input only. Throws Error for an unknown
/// word, or a geometry that leaves no output.
template <class T>
std::vector<std::unique_ptr<Layer<T>>> make_layers(Shape src, const std::vector<std::string>& lines);
/// The layer of a single line.
template <class T>
std::unique_ptr<Layer<T>> make_layer(Shape src, const std::string& line) {
  return std::move(make_layers<T>(src, {line}).front());
}

/// One plane of one block of a tensor.
template <class T>
Plane<T> plane_of(const Tensor<T>& tensor, int block, int channel) {
  return {tensor.row(block, channel, 0), tensor.view().row, tensor.shape().rows, tensor.shape().columns};
}
template <class T>
Plane<const T> const_plane_of(const Tensor<T>& tensor, int block, int channel) {
  return {tensor.row(block, channel, 0), tensor.view().row, tensor.shape().rows, tensor.shape().columns};
}
/// The view of one block, for kernels that read or write it.
template <class T>
View<T> block_of(const Tensor<T>& tensor, int block) {
  View<T> v = tensor.view();
  v.data += block * v.block;
  return v;
}
template <class T>
View<const T> const_block_of(const Tensor<T>& tensor, int block) {
  const View<T> v = block_of(tensor, block);
  return {v.data, v.block, v.channel, v.row};
}

}  // namespace decid::nn
