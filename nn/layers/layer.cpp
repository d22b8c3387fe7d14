// The kinds of layers: their texts, parameters and statistics.
#include "nn/layers/layer.hpp"

#include <algorithm>
#include <utility>

#include "nn/operation.hpp"

namespace decid::nn {
namespace {

std::string pair(int a, int b) {
  return std::to_string(a) + "x" + std::to_string(b);
}

template <class T>
Parameter<T> parameter(const std::string& name, std::vector<int> shape, int fan_in, T initial) {
  std::size_t count = 1;
  for (const int extent : shape) count *= static_cast<std::size_t>(extent);
  return {name, std::move(shape), fan_in, initial, fan_in > 0, std::vector<T>(count, initial)};
}

/// A list in braces would copy them.
template <class T>
std::vector<Parameter<T>> both(Parameter<T> first, Parameter<T> second) {
  std::vector<Parameter<T>> all;
  all.reserve(2);
  all.push_back(std::move(first));
  all.push_back(std::move(second));
  return all;
}

template <class T>
std::vector<Parameter<T>> parameters_of(const LayerKind& kind) {
  if (const auto* conv = std::get_if<Conv2d>(&kind)) {
    const Conv2dShape& s = conv->shape;
    return both(
        parameter("weight", {s.dst_channels, s.src_channels, s.kernel_rows, s.kernel_columns}, conv->taps(), T(0)),
        parameter("bias", {s.dst_channels}, 0, T(0)));
  }
  if (const auto* fc = std::get_if<FullyConnected>(&kind))
    return both(parameter("weight", {fc->outputs, fc->input.size()}, fc->input.size(), T(0)),
                parameter("bias", {fc->outputs}, 0, T(0)));
  if (const auto* norm = std::get_if<BatchNorm>(&kind))
    return both(parameter("gamma", {norm->shape.channels}, 0, T(1)),
                parameter("beta", {norm->shape.channels}, 0, T(0)));
  std::vector<Parameter<T>> own;
  if (const auto* extension = std::get_if<Extension>(&kind))
    for (const OperationParameter& p : extension->operation->parameters())
      own.push_back(parameter(p.name, p.shape, p.fan_in, static_cast<T>(p.initial)));
  return own;
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

std::string Conv2d::text() const {
  return "conv " + std::to_string(shape.dst_channels) + " " + pair(shape.kernel_rows, shape.kernel_columns) +
         " stride " + pair(shape.stride_rows, shape.stride_columns) + " pad " + pair(shape.pad_rows, shape.pad_columns);
}

std::string FullyConnected::text() const {
  return "fc " + std::to_string(outputs);
}

std::string Pool::text() const {
  if (kind == Kind::global_average) return "globalavgpool";
  return (kind == Kind::max ? "maxpool " : "avgpool ") + pair(shape.kernel_rows, shape.kernel_columns) + " stride " +
         pair(shape.stride_rows, shape.stride_columns);
}

std::string BatchNorm::text() const {
  return std::string("batchnorm") + (relu ? "\nrelu" : "") + (pool ? "\n" + pool->text() : "");
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
