// A batch of samples through the steps of inference: see batch.hpp.
#include "nn/training/batch.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "nn/detail/forward.hpp"
#include "nn/operation.hpp"

namespace decid::nn {
namespace {

/// Returns the zeros that the reader of tensor `index` needs around it.
template <class T>
Halo halo_of(const std::vector<Step<T>>& steps, std::size_t index) {
  while (index < steps.size() && steps[index].in_place()) ++index;
  return index < steps.size() ? steps[index].halo() : Halo{};
}

template <class T>
void run_operation(const Step<T>& step, const TensorView<T>& src, const TensorView<T>& dst) {
  const std::vector<std::span<const T>> parameters(step.parameters.begin(), step.parameters.end());
  step.operation->forward(ForwardPass<T>{src, dst, parameters, {}});
}

template <class T>
void join(const Join& join, const TensorView<const T>& kept, const TensorView<T>& src, const TensorView<T>& dst) {
  if (!join.concatenates) return for_each_value([](const T* a, T* b) { *b = *a + *b; }, kept, src);
  copy_planes<T>(kept, dst);
  copy_planes<T>(src, dst, join.kept.channels);
}

template <class T>
void activate(const Step<T>& step, const TensorView<T>& src, const TensorView<T>& dst) {
  // A pool whose windows overlap reads what the activation left in its place.
  const bool pools_apart = step.pool && step.pool->overlaps(), pools = step.pool && !pools_apart;
  const Pooling pooling = pools ? make_pooling(step.pool) : Pooling::none;
  const TensorView<T>& activated = pools ? dst : src;
  for_each_plane(src.blocks(), step.src.channels, [&](int block, int channel) {
    const auto c = static_cast<std::size_t>(channel);
    const bool scales = !step.affine.scale.empty();
    const Activation<T> activation{scales ? step.affine.scale[c] : T(1), scales ? step.affine.shift[c] : T(0),
                                   step.relu, pooling};
    kernels<T>().activation_forward(activation, pools ? step.pool->shape : PoolShape{}, src.plane(block, channel),
                                    activated.plane(block, channel));
  });
  if (pools_apart) pool_forward<T>(*step.pool, src, dst);
}

}  // namespace

template <class T>
BatchExecutor<T>::BatchExecutor(const Inference<T>& inference, int max_batch)
    : inference_(inference), max_batch_(max_batch) {
  if (max_batch < 1 || max_batch > 65536)
    throw Error(Code::setting_out_of_range, "batch", "of " + std::to_string(max_batch) + " samples", "give 1 to 65536");
  // The input has a separate place; all other tensors alternate between two.
  const std::vector<Step<T>>& steps = inference.steps();
  const std::size_t input = TensorView<T>::required(inference.input_shape(), max_batch, halo_of(steps, 0));
  std::size_t pair[2] = {0, 0}, dense = 0;
  std::vector<int> turns;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    turns.push_back(i == 0 ? -1 : turns.back());
    if (steps[i].in_place()) continue;
    turns.back() = turns.back() == 0 ? 1 : 0;
    std::size_t& room = pair[turns.back()];
    room = std::max(room, TensorView<T>::required(steps[i].dst, max_batch, halo_of(steps, i + 1)));
    if (steps[i].kind == Step<T>::Kind::fully_connected)
      dense = std::max(dense, TensorView<T>::required(steps[i].dst, max_batch, {}));
  }
  std::size_t depth = 0;
  for (const Step<T>& step : steps) {
    if (step.kind == Step<T>::Kind::join) --depth;
    if (step.kind != Step<T>::Kind::branch) continue;
    if (kept_.size() == depth) kept_.emplace_back();
    kept_[depth++].reserve(TensorView<T>::required(step.src, max_batch, {}));
  }
  memory_.reserve(input + pair[0] + pair[1]);
  dense_.reserve(dense);
  tensors_.emplace_back(memory_.data(), inference.input_shape(), max_batch, halo_of(steps, 0));
  for (std::size_t i = 0; i < steps.size(); ++i) {
    T* const place = memory_.data() + (turns[i] < 0 ? 0 : input + (turns[i] == 0 ? 0 : pair[0]));
    tensors_.emplace_back(place, steps[i].dst, max_batch, halo_of(steps, i + 1));
  }
}

template <class T>
void BatchExecutor<T>::set_batch(int batch) {
  if (batch < 1 || batch > max_batch_)
    throw Error(Code::setting_out_of_range, "batch",
                "of " + std::to_string(batch) + " samples where the largest is " + std::to_string(max_batch_),
                "make the predictor for the largest batch");
  for (TensorView<T>& t : tensors_) t.set_batch(batch);
}

template <class T>
void BatchExecutor<T>::forward() {
  const std::vector<Step<T>>& steps = inference_.steps();
  std::size_t depth = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Step<T>& step = steps[i];
    const TensorView<T>&src = tensors_[i], &dst = tensors_[i + 1];
    if (!step.in_place()) dst.clear_halo();
    switch (step.kind) {
      case Step<T>::Kind::convolution:
        conv2d_forward<T>(step.conv, src, step.weight, step.bias, dst);
        break;
      case Step<T>::Kind::fully_connected:
        fully_connected_forward<T>(src, step.weight, step.bias, dst, dense_);
        break;
      case Step<T>::Kind::statistics:
        statistics_forward<T>(src, dst);
        break;
      case Step<T>::Kind::activation:
        activate(step, src, dst);
        break;
      case Step<T>::Kind::branch:
        copy_planes<T>(src, {kept_[depth++].data(), step.src, src.batch(), {}});
        break;
      case Step<T>::Kind::join:
        join<T>(step.join, {kept_[--depth].data(), step.join.kept, src.batch(), {}}, src, dst);
        break;
      case Step<T>::Kind::operation:
        run_operation(step, src, dst);
        break;
    }
  }
}

template class BatchExecutor<float>;
template class BatchExecutor<double>;

}  // namespace decid::nn
