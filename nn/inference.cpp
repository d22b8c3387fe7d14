// Lowering of layers into the steps of inference: see inference.hpp.
#include "nn/inference.hpp"

#include <cmath>

#include "nn/layers/detail/normalisation.hpp"
#include "nn/operation.hpp"

namespace decid::nn {
namespace {

/// Orders weights and biases with 16 adjacent outputs, for single samples.
template <class T>
void pack(Step<T>& step) {
  const std::size_t outputs = step.bias.size(), taps = step.weight.size() / outputs;
  const std::size_t padded = (outputs + lanes - 1) / lanes * lanes;
  step.lane_weight.assign(padded * taps, T(0));
  step.lane_bias = step.bias;
  step.lane_bias.resize(padded, T(0));
  for (std::size_t o = 0; o < outputs; ++o)
    for (std::size_t t = 0; t < taps; ++t)
      step.lane_weight[(o / lanes * taps + t) * lanes + o % lanes] = step.weight[o * taps + t];
}

/// BatchNorm with its running statistics.
template <class T>
Affine<T> affine_of(const Layer<T>& layer) {
  const auto value = [](const std::vector<T>& values, std::size_t c) { return static_cast<double>(values[c]); };
  const std::vector<T>&gamma = layer.parameters()[0].value, &beta = layer.parameters()[1].value,
        &mean = layer.statistics()[0].value, &variance = layer.statistics()[1].value;
  Affine<T> affine;
  for (std::size_t c = 0; c < gamma.size(); ++c) {
    const Normalisation n = normalisation(value(gamma, c), value(beta, c), value(mean, c), value(variance, c));
    affine.scale.push_back(static_cast<T>(n.scale));
    affine.shift.push_back(static_cast<T>(n.shift));
  }
  return affine;
}

template <class T>
void fold(const Affine<T>& affine, Step<T>& conv) {
  const std::size_t taps = conv.weight.size() / conv.bias.size();
  for (std::size_t i = 0; i < conv.weight.size(); ++i) conv.weight[i] *= affine.scale[i / taps];
  for (std::size_t o = 0; o < conv.bias.size(); ++o)
    conv.bias[o] = std::fma(conv.bias[o], affine.scale[o], affine.shift[o]);
}

Conv2dShape as_convolution(const FullyConnected& fc) {
  const Shape& s = fc.input;
  return {s.channels, s.rows, s.columns, fc.outputs, 1, 1, s.rows, s.columns, 1, 1, 0, 0};
}

template <class T>
Step<T> step_of(const Layer<T>& layer) {
  using Kind = typename Step<T>::Kind;
  Step<T> step;
  step.src = layer.src_shape();
  step.dst = layer.dst_shape();
  if (const auto* conv = std::get_if<Conv2d>(&layer.kind())) {
    step.kind = Kind::convolution;
    step.conv = conv->shape;
  } else if (const auto* fc = std::get_if<FullyConnected>(&layer.kind())) {
    step.kind = Kind::fully_connected;
    step.conv = as_convolution(*fc);
  } else if (const auto* norm = std::get_if<BatchNorm>(&layer.kind())) {
    step.affine = affine_of(layer);
    step.relu = norm->relu;
    step.pool = norm->pool;
  } else if (const auto* pool = std::get_if<Pool>(&layer.kind())) {
    step.pool = *pool;
  } else if (std::holds_alternative<StatisticsPool>(layer.kind())) {
    step.kind = Kind::statistics;
  } else if (std::holds_alternative<Branch>(layer.kind())) {
    step.kind = Kind::branch;
  } else if (const auto* join = std::get_if<Join>(&layer.kind())) {
    step.kind = Kind::join;
    step.join = *join;
  } else if (const auto* extension = std::get_if<Extension>(&layer.kind())) {
    step.kind = Kind::operation;
    step.operation = extension->operation;
    for (const Parameter<T>& p : layer.parameters()) step.parameters.push_back(p.value);
    return step;
  } else {
    step.relu = true;
  }
  if (!layer.parameters().empty() && step.affine.scale.empty()) {
    step.weight = layer.parameters()[0].value;
    step.bias = layer.parameters()[1].value;
  }
  return step;
}

}  // namespace

template <class T>
Inference<T>::Inference(std::span<const Layer<T>> layers) {
  for (const Layer<T>& layer : layers) {
    Step<T> step = step_of(layer);
    if (!step.affine.scale.empty() && !steps_.empty() && steps_.back().kind == Step<T>::Kind::convolution) {
      fold(step.affine, steps_.back());
      step.affine = {};
    }
    steps_.push_back(std::move(step));
  }
  for (Step<T>& step : steps_)
    if (!step.weight.empty()) pack(step);
}

template <class T>
Halo Step<T>::halo() const {
  return kind == Kind::convolution ? src_halo(conv) : kind == Kind::operation ? operation->src_halo() : Halo{};
}

template <class T>
int Inference<T>::feature_count() const {
  const Step<T>& last = steps_.back();
  return last.kind == Step<T>::Kind::fully_connected && steps_.size() > 1 ? last.src.size() : 0;
}

template <class T>
std::size_t Inference<T>::bytes() const {
  std::size_t values = 0;
  for (const Step<T>& s : steps_)
    values += s.weight.size() + s.bias.size() + s.lane_weight.size() + s.lane_bias.size() + 2 * s.affine.scale.size();
  for (const Step<T>& s : steps_)
    for (const std::vector<T>& p : s.parameters) values += p.size();
  return values * sizeof(T);
}

template struct Step<float>;
template struct Step<double>;
template class Inference<float>;
template class Inference<double>;

}  // namespace decid::nn
