// Training of a network: its memory, forward and backward.
#include "nn/training/trainer.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "nn/layers/training_layer.hpp"
#include "nn/training/all_reduce.hpp"

namespace decid::nn {
namespace {

/// Throws Error if a BatchNorm has a single value per channel in a batch of that many samples. Such a value is its own
/// mean: the layer's output would not depend on the samples, and the running variance would move towards 0.
template <class T>
void refuse_lone_values(const Network<T>& network, int batch) {
  const auto is_lone = [](const Layer<T>& layer) {
    const auto* const norm = std::get_if<BatchNorm>(&layer.kind());
    return norm != nullptr && norm->shape.rows == 1 && norm->shape.columns == 1;
  };
  const auto found = std::ranges::find_if(network.layers(), is_lone);
  if (batch > 1 || found == network.layers().end()) return;
  std::size_t line = 0;
  for (auto before = network.layers().begin(); before != found; ++before) line += before->lines();
  throw Error(Code::setting_out_of_range, "layers." + std::to_string(line) + ", batchnorm",
              "has 1 value a channel in a batch of 1 sample, and no variance to normalise by",
              "give batches of 2 samples or more");
}

}  // namespace

template <class T>
Trainer<T>::Trainer(Network<T>& network, int max_batch, Communicator* ranks, bool with_input_diff)
    : network_(network),
      max_batch_(max_batch),
      ranks_(ranks),
      with_input_diff_(with_input_diff),
      own_batch_(max_batch) {
  if (max_batch < 1 || max_batch > 65536)
    throw Error(Code::setting_out_of_range, "batch", "of " + std::to_string(max_batch) + " samples", "give 1 to 65536");
  if (ranks != nullptr) {
    all_reduce_ = std::make_unique<AllReduce<T>>(*ranks);
    const auto blocks = static_cast<int>(TensorView<T>::count_blocks(max_batch));
    own_batch_ = std::min(max_batch, max_blocks(blocks, ranks->size()) * lanes);
  }
  OpenSkips<T> open;
  for (Layer<T>& layer : network.layers()) {
    layers_.push_back(
        make_training_layer<T>(layer, own_batch_, layers_.empty() ? nullptr : layers_.back().get(), open));
    if (all_reduce_) layers_.back()->share_batch(*all_reduce_);
    for (std::size_t k = 0; k < layer.parameters().size(); ++k) gradients_.emplace_back(layers_.back()->gradient(k));
  }
  plan();
  set_batch(max_batch);
}

template <class T>
Trainer<T>::Trainer(Trainer&&) noexcept = default;
template <class T>
Trainer<T>::~Trainer() = default;

// The tensor behind activation `index` is read by the layers that follow it, up to the first not in place.
template <class T>
Halo Trainer<T>::activation_halo(std::size_t index) const {
  Halo halo;
  for (std::size_t i = index; i < layers_.size(); ++i) {
    halo = larger(halo, layers_[i]->src_halo());
    if (!layers_[i]->in_place()) break;
  }
  return halo;
}

// Its derivative is read by the layer that made it, before any that worked in place.
template <class T>
Halo Trainer<T>::difference_halo(std::size_t index) const {
  while (index > 0 && layers_[index - 1]->in_place()) --index;
  return index > 0 ? layers_[index - 1]->diff_dst_halo() : Halo{};
}

// The derivative by activation `index` takes its place: the layer that follows allows it, and the layer before no
// longer needs its output. (The derivative by the input is not computed.)
template <class T>
bool Trainer<T>::difference_replaces_activation(std::size_t index) const {
  return index > 0 && index < layers_.size() && layers_[index]->diff_may_replace_src() &&
         !layers_[index - 1]->backward_reads_dst();
}

// Every activation is kept for backward; of the derivatives that do not replace one, two at a time.
template <class T>
void Trainer<T>::plan() {
  struct Layout {
    Shape shape;
    std::size_t activation = 0;  // offset
    int turn = 0;                // which of the two
    Halo activation_halo, difference_halo;
  };
  std::vector<Layout> layouts(layers_.size() + 1);
  std::size_t kept = 0, pair[2] = {0, 0};
  for (std::size_t i = 0; i < layouts.size(); ++i) {
    Layout& layout = layouts[i];
    layout.shape = i > 0 ? layers_[i - 1]->layer().dst_shape() : network_.input_shape();
    layout.activation_halo = activation_halo(i);
    layout.difference_halo = difference_halo(i);
    if (difference_replaces_activation(i))
      layout.activation_halo = layout.difference_halo = larger(layout.activation_halo, layout.difference_halo);
    if (i > 0 && layers_[i - 1]->in_place()) {
      layout.activation = layouts[i - 1].activation;
      layout.turn = layouts[i - 1].turn;
      continue;
    }
    layout.turn = i > 0 ? 1 - layouts[i - 1].turn : 0;
    layout.activation = kept;
    kept += TensorView<T>::required(layout.shape, own_batch_, layout.activation_halo);
    if ((i > 0 || with_input_diff_) && !difference_replaces_activation(i))
      pair[layout.turn] =
          std::max(pair[layout.turn], TensorView<T>::required(layout.shape, own_batch_, layout.difference_halo));
  }
  memory_.reserve(kept + pair[0] + pair[1]);
  for (std::size_t i = 0; i < layouts.size(); ++i) {
    const Layout& layout = layouts[i];
    T* const own = memory_.data() + layout.activation;
    T* const shared = memory_.data() + kept + (layout.turn == 0 ? 0 : pair[0]);
    activations_.emplace_back(own, layout.shape, own_batch_, layout.activation_halo);
    differences_.emplace_back(difference_replaces_activation(i) ? own : shared, layout.shape, own_batch_,
                              layout.difference_halo);
  }
}

template <class T>
void Trainer<T>::set_batch(int batch) {
  if (batch < 1 || batch > max_batch_)
    throw Error(Code::setting_out_of_range, "batch",
                "of " + std::to_string(batch) + " samples where the largest is " + std::to_string(max_batch_),
                "make the trainer for the largest batch");
  if (!frozen_statistics_) refuse_lone_values(network_, batch);
  if (all_reduce_) {
    all_reduce_->set_batch(batch);
    batch = static_cast<int>(own_samples(batch).size());
  }
  for (TensorView<T>& t : activations_) t.set_batch(batch);
  for (TensorView<T>& t : differences_) t.set_batch(batch);
}

template <class T>
std::vector<int> Trainer<T>::own_samples(int batch) const {
  std::vector<int> samples;
  const auto add = [&](int first, int last) {
    for (int i = first; i < std::min(last, batch); ++i) samples.push_back(i);
  };
  if (ranks_ == nullptr) add(0, batch);
  if (ranks_ != nullptr)
    for (const int block :
         make_partition(static_cast<int>(TensorView<T>::count_blocks(batch)), ranks_->rank(), ranks_->size()).blocks)
      add(block * lanes, (block + 1) * lanes);
  return samples;
}

template <class T>
void Trainer<T>::set_random(std::uint64_t seed, std::uint64_t step) {
  for (std::size_t i = 0; i < layers_.size(); ++i)
    if (layers_[i]->is_random()) layers_[i]->set_random(Random(seed, Stream::dropout, step << 16U | i));
}

template <class T>
void Trainer<T>::freeze_statistics() {
  frozen_statistics_ = true;
  for (const auto& layer : layers_) layer->freeze_statistics();
}

template <class T>
void Trainer<T>::forward() {
  for (std::size_t i = 0; i < layers_.size(); ++i) layers_[i]->forward(activations_[i], activations_[i + 1]);
}

template <class T>
void Trainer<T>::backward() {
  differences_.back().clear_halo();
  for (std::size_t i = layers_.size(); i-- > 0;) {
    const TensorView<T>* const diff_src = i > 0 || with_input_diff_ ? &differences_[i] : nullptr;
    if (diff_src != nullptr && !layers_[i]->in_place()) diff_src->clear_halo();
    layers_[i]->backward(activations_[i], activations_[i + 1], differences_[i + 1], diff_src);
    if (all_reduce_) all_reduce_->progress();
  }
  if (all_reduce_) all_reduce_->finish();
}

template <class T>
std::span<const T> Trainer<T>::gradient(std::size_t parameter) const {
  if (parameter >= gradients_.size())
    throw Error(Code::setting_out_of_range, "gradient",
                "of parameter " + std::to_string(parameter) + " of " + std::to_string(gradients_.size()),
                "give its index in network().parameters(), from 0");
  return gradients_[parameter];
}

template <class T>
std::span<T> Trainer<T>::gradient(std::size_t parameter) {
  static_cast<void>(std::as_const(*this).gradient(parameter));  // throws
  return gradients_[parameter];
}

template class Trainer<float>;
template class Trainer<double>;

}  // namespace decid::nn
