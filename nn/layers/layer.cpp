// The kinds of layers: their parameters and statistics.
#include "nn/layers/layer.hpp"

#include <algorithm>

#include "nn/operation.hpp"

namespace decid::nn {
namespace {

/// The trained tensors of a kind, without their values.
std::vector<OperationParameter> described_parameters(const LayerKind& kind) {
  if (const auto* conv = std::get_if<Conv2d>(&kind)) {
    const Conv2dShape& s = conv->shape;
    return {{"weight", {s.dst_channels, s.src_channels, s.kernel_rows, s.kernel_columns}, conv->taps(), 0},
            {"bias", {s.dst_channels}, 0, 0}};
  }
  if (const auto* fc = std::get_if<FullyConnected>(&kind))
    return {{"weight", {fc->outputs, fc->input.size()}, fc->input.size(), 0}, {"bias", {fc->outputs}, 0, 0}};
  if (const auto* norm = std::get_if<BatchNorm>(&kind))
    return {{"gamma", {norm->shape.channels}, 0, 1}, {"beta", {norm->shape.channels}, 0, 0}};
  if (const auto* extension = std::get_if<Extension>(&kind)) return extension->operation->parameters();
  return {};
}

std::size_t value_count(const OperationParameter& parameter) {
  std::size_t count = 1;
  for (const int extent : parameter.shape) count *= static_cast<std::size_t>(extent);
  return count;
}

template <class T>
std::vector<Parameter<T>> parameters_of(const LayerKind& kind) {
  std::vector<Parameter<T>> all;
  for (const OperationParameter& p : described_parameters(kind)) {
    const T initial = static_cast<T>(p.initial);
    all.push_back({p.name, p.shape, p.fan_in, initial, p.fan_in > 0, std::vector<T>(value_count(p), initial)});
  }
  return all;
}

template <class T>
std::vector<RunningStatistics<T>> statistics_of(const LayerKind& kind) {
  const auto* norm = std::get_if<BatchNorm>(&kind);
  if (norm == nullptr) return {};
  const auto channels = static_cast<std::size_t>(norm->shape.channels);
  return {{"running_mean", T(0), false, std::vector<T>(channels, T(0))},
          {"running_variance", T(1), true, std::vector<T>(channels, T(1))}};
}

}  // namespace

std::size_t parameter_count(const LayerKind& kind) {
  std::size_t count = 0;
  for (const OperationParameter& p : described_parameters(kind)) count += value_count(p);
  return count;
}

Shape Extension::src() const {
  return operation->src();
}
Shape Extension::dst() const {
  return operation->dst();
}
std::string Extension::text() const {
  return operation->text();
}
long long Extension::flops() const {
  return operation->flops();
}

template <class T>
Layer<T>::Layer(const LayerKind& kind)
    : kind_(kind), parameters_(parameters_of<T>(kind)), statistics_(statistics_of<T>(kind)) {}

template <class T>
Shape Layer<T>::src_shape() const {
  return std::visit([](const auto& kind) { return kind.src(); }, kind_);
}

template <class T>
Shape Layer<T>::dst_shape() const {
  return std::visit([](const auto& kind) { return kind.dst(); }, kind_);
}

template <class T>
std::string Layer<T>::text() const {
  return std::visit([](const auto& kind) { return kind.text(); }, kind_);
}

template <class T>
std::size_t Layer<T>::lines() const {
  const std::string all = text();
  return 1 + static_cast<std::size_t>(std::count(all.begin(), all.end(), '\n'));
}

template <class T>
long long Layer<T>::flops() const {
  return std::visit([](const auto& kind) { return kind.flops(); }, kind_);
}

template class Layer<float>;
template class Layer<double>;

}  // namespace decid::nn
