// A layer in training: a forward/backward pair over batches, with the gradients of the layer's parameters and the
// scratch memory that both need. A Trainer chains them.
#pragma once

#include <memory>
#include <vector>

#include "base/math/random.hpp"
#include "nn/fusion.hpp"
#include "nn/layers/layer.hpp"
#include "nn/layers/skip.hpp"
#include "nn/tensor.hpp"
#include "nn/training/all_reduce.hpp"

namespace decid::nn {

template <class T>
class TrainingLayer {
 public:
  explicit TrainingLayer(Layer<T>& layer) : layer_(layer) {
    for (const Parameter<T>& p : layer.parameters()) gradients_.emplace_back(p.value.size(), T(0));
  }
  virtual ~TrainingLayer() = default;

  const Layer<T>& layer() const { return layer_; }
  /// Returns the gradient of the parameter with that index in layer().parameters().
  std::vector<T>& gradient(std::size_t parameter) { return gradients_[parameter]; }
  /// Shares the batch with other processes from now on; the gradients of backward are complete after
  /// all_reduce.finish(). `all_reduce` must outlive the layer's work.
  void share_batch(AllReduce<T>& all_reduce) { all_reduce_ = &all_reduce; }

  /// Returns true if dst is src's memory, and backward turns diff_dst into diff_src in place.
  virtual bool in_place() const { return false; }
  /// Returns true if diff_src may be src's memory: backward reads each value of src before it writes there.
  virtual bool diff_may_replace_src() const { return false; }
  /// Returns true if backward reads dst, so that the next layer must not overwrite it: a ReLU gets memory of its own.
  virtual bool backward_reads_dst() const { return false; }
  /// Returns the zeros that this layer reads around src in forward and backward, and around diff_dst in backward.
  virtual Halo src_halo() const { return {}; }
  virtual Halo diff_dst_halo() const { return {}; }
  /// Makes forward compute the sums of the next BatchNorm from now on, see fusion.hpp. Returns false if this layer
  /// cannot.
  virtual bool fuse(BatchSums<T>& sums) {
    (void)sums;
    return false;
  }

  /// Returns true if forward draws random numbers: those of set_random(), or none if set_random() was never called.
  virtual bool is_random() const { return false; }
  virtual void set_random(const Random&) {}
  /// Makes forward use the running statistics, as inference does, and leave them, from now on.
  virtual void freeze_statistics() {}

  /// Computes dst with the batch's statistics, and updates the running statistics, unless they are frozen.
  virtual void forward(const TensorView<const T>& src, const TensorView<T>& dst) = 0;
  /// Writes, after forward, the gradients and, unless null, diff_src; may overwrite diff_dst.
  virtual void backward(const TensorView<const T>& src, const TensorView<const T>& dst, const TensorView<T>& diff_dst,
                        const TensorView<T>* diff_src) = 0;

 protected:
  std::vector<T>& value(std::size_t parameter) { return layer_.parameters()[parameter].value; }
  const std::vector<T>& value(std::size_t parameter) const { return layer_.parameters()[parameter].value; }
  std::vector<T>& statistic(std::size_t index) { return layer_.statistics()[index].value; }
  /// Returns null if this process has the whole batch.
  AllReduce<T>* all_reduce() const { return all_reduce_; }

 private:
  Layer<T>& layer_;
  std::vector<std::vector<T>> gradients_;
  AllReduce<T>* all_reduce_ = nullptr;
};

/// Makes `layer` trainable, with the memory for up to `max_batch` samples; see Trainer for what allocates later. If it
/// is a BatchNorm, `before`, unless null, is fused with it; if it is a ReLU, it overwrites that layer's output if it
/// may. `open`: the open skips of the layer's chain.
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training_layer(Layer<T>& layer, int max_batch, TrainingLayer<T>* before,
                                                      OpenSkips<T>& open);
/// Makes a layer trainable that is not the beginning or end of a block.
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training_layer(Layer<T>& layer, int max_batch) {
  OpenSkips<T> none;
  return make_training_layer<T>(layer, max_batch, nullptr, none);
}

}  // namespace decid::nn
