// A chain of layers: construction from text, memory plan, forward and backward.
#include "nn/network.hpp"

#include <omp.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <sstream>

#include "base/error.hpp"
#include "base/random.hpp"
#include "base/sha256.hpp"
#include "nn/sharing.hpp"

namespace decid::nn {

template <class T>
Network<T>::Network(Shape input, const std::string& architecture) : input_shape_(input) {
  if (input.channels < 1 || input.rows < 1 || input.columns < 1)
    throw Error("network input", "has no values", "give at least 1 channel, 1 row and 1 column");
  if (input.channels > most_values / input.rows / input.columns)
    throw Error("network input", "has more than " + std::to_string(most_values) + " values a sample", "give fewer");
  std::string lines = architecture;
  for (char& c : lines)
    if (c == ';') c = '\n';
  std::istringstream stream(lines);
  std::vector<std::string> wanted;
  for (std::string line; std::getline(stream, line);)
    if (line.find_first_not_of(" \t\r") != std::string::npos) wanted.push_back(line);
  layers_ = make_layers<T>(input, wanted);
  if (layers_.empty() || layers_.front()->in_place())
    throw Error("network architecture", "does not begin with a layer that computes", "start with conv or fc");
  for (const auto& layer : layers_)
    for (Parameter<T>* p : layer->parameters()) parameters_.push_back(p);
}

template <class T>
std::string Network<T>::architecture() const {
  std::string text;
  for (const auto& layer : layers_) text += (text.empty() ? "" : "\n") + layer->text();
  return text;
}

template <class T>
std::size_t Network<T>::parameter_count() const {
  std::size_t count = 0;
  for (const Parameter<T>* p : parameters_) count += p->value.size();
  return count;
}

template <class T>
long long Network<T>::flops() const {
  long long sum = 0;
  for (const auto& layer : layers_) sum += layer->flops();
  return sum;
}

template <class T>
void Network<T>::initialise(std::uint64_t seed) {
  std::uint64_t item = 0;
  for (Parameter<T>* p : parameters_) {
    const Random random(seed, Stream::weights, item++);
    const double deviation = p->fan_in > 0 ? std::sqrt(2.0 / p->fan_in) : 0.0;
    for (std::size_t i = 0; i < p->value.size(); ++i)
      p->value[i] = p->fan_in > 0 ? static_cast<T>(deviation * random.normal(i)) : p->initial;
    p->velocity.assign(p->value.size(), T(0));
  }
  for (const auto& layer : layers_)
    for (Statistic<T>* s : layer->statistics()) s->value.assign(s->value.size(), s->initial);
}

// The tensor behind activation `index` is read by the layers that follow it, up to the first not in place.
template <class T>
int Network<T>::activation_halo(std::size_t index) const {
  int halo = 0;
  for (std::size_t i = index; i < layers_.size(); ++i) {
    halo = std::max(halo, layers_[i]->src_halo());
    if (!reuses_source(i)) break;
  }
  return halo;
}

// Its derivative is read by the layer that made it, before any that worked in place.
template <class T>
int Network<T>::difference_halo(std::size_t index) const {
  while (index > 0 && reuses_source(index - 1)) --index;
  return index > 0 ? layers_[index - 1]->diff_dst_halo() : 0;
}

// The derivative by activation `index` takes its place: the layer that follows allows it, and the one before has no
// more use for what it made. (No one asks for the derivative by the input.)
template <class T>
bool Network<T>::difference_replaces_activation(std::size_t index) const {
  return index > 0 && index < layers_.size() && layers_[index]->diff_may_replace_src() &&
         !layers_[index - 1]->backward_reads_dst();
}

// In inference the input and the output hold the whole batch, with what shares their memory.
template <class T>
bool Network<T>::whole(std::size_t activation) const {
  if (mode_ == Mode::training || activation == 0) return true;
  for (std::size_t i = activation; i < layers_.size(); ++i)
    if (!reuses_source(i)) return false;
  return true;
}

template <class T>
void Network<T>::plan(int batch, Mode mode) {
  if (batch < 1 || batch > 65536) throw Error("batch", "of " + std::to_string(batch) + " samples", "give 1 to 65536");
  mode_ = mode;
  planned_batch_ = batch_ = batch;
  // Training keeps every activation for backward, and of the derivatives that have no place there two at a time;
  // inference keeps the input, the output and two activations of a few samples, a block for each thread.
  const bool training = mode == Mode::training;
  at_once_ = training ? batch : static_cast<int>(std::min<long long>(batch, 1LL * lanes * omp_get_max_threads()));
  struct Place {
    Shape shape;
    std::size_t kept = 0;  // offset of the activation in training
    int turn = 0;          // which of the two
    int activation_halo = 0, difference_halo = 0;
  };
  std::vector<Place> places(layers_.size() + 1);
  std::size_t kept = 0, pair[2] = {0, 0};
  for (std::size_t i = 0; i < places.size(); ++i) {
    Place& place = places[i];
    place.shape = i > 0 ? layers_[i - 1]->dst_shape() : input_shape_;
    place.activation_halo = activation_halo(i);
    place.difference_halo = difference_halo(i);
    if (difference_replaces_activation(i))
      place.activation_halo = place.difference_halo = std::max(place.activation_halo, place.difference_halo);
    if (i > 0 && reuses_source(i - 1)) {
      place.kept = places[i - 1].kept;
      place.turn = places[i - 1].turn;
      continue;
    }
    place.turn = i > 0 ? 1 - places[i - 1].turn : 0;
    const std::size_t activation = Tensor<T>::required(place.shape, whole(i) ? batch : at_once_, place.activation_halo);
    const std::size_t difference = Tensor<T>::required(place.shape, batch, place.difference_halo);
    place.kept = kept;
    if (whole(i)) kept += activation;
    if (!whole(i))
      pair[place.turn] = std::max(pair[place.turn], activation);
    else if (training && i > 0 && !difference_replaces_activation(i))
      pair[place.turn] = std::max(pair[place.turn], difference);
  }
  memory_.reserve(kept + pair[0] + pair[1]);
  activations_.clear();
  differences_.clear();
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& place = places[i];
    T* const own = memory_.data() + place.kept;
    T* const shared = memory_.data() + kept + (place.turn == 0 ? 0 : pair[0]);
    activations_.emplace_back(whole(i) ? own : shared, place.shape, batch, place.activation_halo);
    if (whole(i)) activations_.back().clear_halo();
    if (!training) continue;
    differences_.emplace_back(difference_replaces_activation(i) ? own : shared, place.shape, batch,
                              place.difference_halo);
  }
  for (const auto& layer : layers_) layer->plan(batch, mode);
  if (training) join(layers_);
  fold();
}

// In inference a convolution does what is affine in the layer after it.
template <class T>
void Network<T>::fold() {
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    const bool before = i > 0 && mode_ == Mode::inference && layers_[i - 1]->fold({});
    const Affine<T> affine = layers_[i]->take_affine(before);
    if (before) layers_[i - 1]->fold(affine);
  }
}

template <class T>
void Network<T>::set_batch(int batch) {
  if (batch < 1 || batch > planned_batch_)
    throw Error("batch",
                "of " + std::to_string(batch) + " samples where " + std::to_string(planned_batch_) + " were planned",
                "plan() for the largest batch first");
  batch_ = batch;
  for (Tensor<T>& t : activations_) t.set_batch(batch);
  for (Tensor<T>& t : differences_) t.set_batch(batch);
}

template <class T>
void Network<T>::forward() {
  if (planned_batch_ == 0) throw Error("network", "has no memory yet", "plan() it before forward()");
  if (mode_ == Mode::inference) {
    infer();
    return;
  }
  for (std::size_t i = 0; i < layers_.size(); ++i) layers_[i]->forward(activations_[i], activations_[i + 1], mode_);
}

template <class T>
Tensor<T> Network<T>::infer_part(int first, int count, std::size_t layers) {
  const auto part = [&](std::size_t activation) {
    return activations_[activation].part(whole(activation) ? first / lanes : 0, count);
  };
  for (std::size_t i = 0; i < layers; ++i) {
    const Tensor<T> dst = part(i + 1);
    if (!whole(i + 1) && !reuses_source(i)) dst.clear_halo();
    layers_[i]->forward(part(i), dst, mode_);
  }
  return part(layers);
}

// A few samples through all layers, then the next: what one layer writes is still in the cache when the next reads it.
template <class T>
void Network<T>::infer() {
  for (int first = 0; first < batch_; first += at_once_)
    infer_part(first, std::min(at_once_, batch_ - first), layers_.size());
}

template <class T>
void Network<T>::activation(std::size_t layer, int sample, std::span<T> values) {
  if (planned_batch_ == 0 || mode_ != Mode::inference)
    throw Error("activation", "needs a network in inference", "plan() it for inference");
  if (layer >= layers_.size() || sample < 0 || sample >= batch_)
    throw Error("activation",
                "of layer " + std::to_string(layer) + " and sample " + std::to_string(sample) + " where there are " +
                    std::to_string(layers_.size()) + " layers and " + std::to_string(batch_) + " samples",
                "count both from 0");
  if (values.size() != static_cast<std::size_t>(layers_[layer]->dst_shape().size()))
    throw Error("activation", "has another size than the room for it", "give dst_shape().size() values");
  const int first = sample / lanes * lanes;
  infer_part(first, std::min(lanes, batch_ - first), layer + 1).store(sample - first, values);
}

template <class T>
void Network<T>::backward() {
  if (mode_ != Mode::training)
    throw Error("network", "was planned for inference", "plan() it for training before backward()");
  differences_.back().clear_halo();
  for (std::size_t i = layers_.size(); i-- > 0;) {
    const Tensor<T>* const diff_src = gives_diff_src(layers_, i) ? &differences_[i] : nullptr;
    if (diff_src != nullptr && !reuses_source(i)) diff_src->clear_halo();
    layers_[i]->backward(activations_[i], activations_[i + 1], differences_[i + 1], diff_src);
  }
}

template <class T>
void sgd_step(const Network<T>& network, double learning_rate, const SgdSettings& settings) {
  for (Parameter<T>* p : network.parameters())
    for_each_group(1, static_cast<int>(p->value.size()), value_group, [&](int, int first, int last) {
      kernels<T>().sgd_step(static_cast<std::size_t>(last - first), static_cast<T>(learning_rate),
                            static_cast<T>(settings.momentum), static_cast<T>(p->decays ? settings.weight_decay : 0.0),
                            p->gradient.data() + first, p->velocity.data() + first, p->value.data() + first);
    });
}

std::string weights_sha256(const Network<float>& network) {
  static_assert(std::endian::native == std::endian::little, "values are hashed as they lie in memory");
  Sha256 hash;
  const auto add = [&](const std::string& name, const std::vector<int>& shape, const std::vector<float>& values) {
    std::string header = name + ":";
    for (const int extent : shape) header += std::to_string(extent) + ",";
    header += ";";
    hash.update(header.data(), header.size());
    hash.update(values.data(), values.size() * sizeof(float));
  };
  std::size_t line = 0;
  for (const auto& layer : network.layers()) {
    const std::string prefix = std::to_string(line) + ".";
    for (const Parameter<float>* p : layer->parameters()) add(prefix + p->name, p->shape, p->value);
    for (const Statistic<float>* s : layer->statistics())
      add(prefix + s->name, {static_cast<int>(s->value.size())}, s->value);
    line += layer->lines();
  }
  return hash.hex();
}

template class Network<float>;
template class Network<double>;
template void sgd_step(const Network<float>&, double, const SgdSettings&);
template void sgd_step(const Network<double>&, double, const SgdSettings&);

}  // namespace decid::nn
