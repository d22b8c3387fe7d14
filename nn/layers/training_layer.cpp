// Makes the TrainingLayer of each kind of layer.
#include "nn/layers/training_layer.hpp"

#include "nn/layers/detail/training_layers.hpp"

namespace decid::nn {

template <class T>
std::unique_ptr<TrainingLayer<T>> make_training_layer(Layer<T>& layer, int max_batch, TrainingLayer<T>* before,
                                                      OpenSkips<T>& open) {
  if (const auto* conv = std::get_if<Conv2d>(&layer.kind())) return make_training(layer, *conv, max_batch);
  if (const auto* fc = std::get_if<FullyConnected>(&layer.kind())) return make_training(layer, *fc, max_batch);
  if (const auto* norm = std::get_if<BatchNorm>(&layer.kind())) return make_training(layer, *norm, max_batch, before);
  if (const auto* relu = std::get_if<Relu>(&layer.kind())) return make_training(layer, *relu, before);
  if (const auto* pool = std::get_if<Pool>(&layer.kind())) return make_training(layer, *pool);
  if (const auto* branch = std::get_if<Branch>(&layer.kind())) return make_training(layer, *branch, max_batch, open);
  if (const auto* join = std::get_if<Join>(&layer.kind())) return make_training(layer, *join, open);
  if (const auto* extension = std::get_if<Extension>(&layer.kind())) return make_training(layer, *extension, max_batch);
  return make_training(layer, std::get<StatisticsPool>(layer.kind()));
}

template std::unique_ptr<TrainingLayer<float>> make_training_layer(Layer<float>&, int, TrainingLayer<float>*,
                                                                   OpenSkips<float>&);
template std::unique_ptr<TrainingLayer<double>> make_training_layer(Layer<double>&, int, TrainingLayer<double>*,
                                                                    OpenSkips<double>&);

}  // namespace decid::nn
