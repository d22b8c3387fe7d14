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
  /// Of the parameter with that index in layer().parameters().
  std::vector<T>& gradient(std::size_t parameter) { return gradients_[parameter]; }
  /// From now on the batch is shared with other processes, and the gradients that backward leaves are there after
  /// reducer.finish(). It must outlive the layer's work.
  void share_batch(AllReduce<T>& all_reduce) { all_reduce_ = &all_reduce; }

  /// dst is src's memory, and backward turns diff_dst into diff_src where it stands.
  virtual bool in_place() const { return false; }
  /// diff_src may be src's memory: backward reads each value of src before it writes there.
  virtual bool diff_may_replace_src() const { return false; }
  /// backward reads dst, so that the layer behind must not overwrite it.
  virtual bool backward_reads_dst() const { return false; }
  /// Zeros that this layer reads around src in forward and backward, and around diff_dst in backward.
  virtual Halo src_halo() const { return {}; }
  virtual Halo diff_dst_halo() const { return {}; }
  /// From now on forward takes the sums of the BatchNorm behind it, as fusion.hpp says. False if this layer cannot.
  virtual bool fuse(BatchSums<T>& sums) {
    (void)sums;
    return false;
  }

  /// Draws random numbers in forward: those of set_random(), or none if that was never called.
  virtual bool is_random() const { return false; }
  virtual void set_random(const Random&) {}

  /// With the batch's statistics, moving the running ones.
  virtual void forward(const TensorView<const T>& src, const TensorView<T>& dst) = 0;
  /// After forward. Writes the gradients and, unless null, diff_src; may use up diff_dst.
  virtual void backward(const TensorView<const T>& src, const TensorView<const T>& dst, const TensorView<T>& diff_dst,
                        const TensorView<T>* diff_src) = 0;

 protected:
  std::vector<T>& value(std::size_t parameter) { return layer_.parameters()[parameter].value; }
  const std::vector<T>& value(std::size_t parameter) const { return layer_.parameters()[parameter].value; }
  std::vector<T>& statistic(std::size_t index) { return layer_.statistics()[index].value; }
  /// Null: this process has the whole batch.
  AllReduce<T>* all_reduce() const { return all_reduce_; }

 private:
  Layer<T>& layer_;
  std::vector<std::vector<T>> gradients_;
  AllReduce<T>* all_reduce_ = nullptr;
};

/// `layer` in training, with the memory for up to `max_batch` samples; no later call allocates. If it is a
/// BatchNorm, `before`, unless null, is fused with it. `open`: of the chain that the layer is in.
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training_layer(Layer<T>& layer, int max_batch, TrainingLayer<T>* before,
                                                      OpenSkips<T>& open);
/// A layer that is no beginning or end of a block.
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training_layer(Layer<T>& layer, int max_batch) {
  OpenSkips<T> none;
  return make_training_layer<T>(layer, max_batch, nullptr, none);
}

}  // namespace decid::nn
