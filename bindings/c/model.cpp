// Models in C.
#include "base/files/file.hpp"
#include "bindings/c/handles.hpp"

using namespace decid::c;

namespace {

void set_shape(const decid::nn::Shape& from, size_t (&to)[3]) {
  to[0] = static_cast<size_t>(from.channels);
  to[1] = static_cast<size_t>(from.rows);
  to[2] = static_cast<size_t>(from.columns);
}

decid_tensor tensor_of(const char* name, const std::vector<float>& values, std::span<const int> shape) {
  decid_tensor tensor{name, values.data(), shape.size(), {}};
  if (shape.size() > std::size(tensor.shape))
    throw decid::Error(decid::Code::not_supported, name, "has " + std::to_string(shape.size()) + " dimensions",
                       "give a model whose tensors have at most " + std::to_string(std::size(tensor.shape)));
  std::copy(shape.begin(), shape.end(), tensor.shape);
  return tensor;
}

}  // namespace

decid_model::decid_model(decid::Model of, std::string called)
    : model(std::move(of)),
      name(std::move(called)),
      protocol(model.protocol),
      head(model.head->name()),
      sha256(decid::nn::weights_sha256(model.network)),
      identifier(std::make_shared<const decid::Identifier>(model)) {
  std::size_t line = 0;  // tensors are named as in nn/safetensors.cpp
  for (const decid::nn::Layer<float>& layer : std::as_const(model.network).layers()) {
    decid_layer& described = layers.emplace_back();
    described.text = texts.emplace_back(layer.text()).c_str();
    set_shape(layer.src_shape(), described.input_shape);
    set_shape(layer.dst_shape(), described.output_shape);
    described.flops = static_cast<uint64_t>(layer.flops());
    const std::string prefix = "layers." + std::to_string(line) + ".";
    line += layer.lines();
    for (const auto& parameter : layer.parameters())
      tensors.push_back(
          tensor_of(texts.emplace_back(prefix + parameter.name).c_str(), parameter.value, parameter.shape));
    for (const auto& statistic : layer.statistics()) {
      const int values = static_cast<int>(statistic.value.size());
      tensors.push_back(
          tensor_of(texts.emplace_back(prefix + statistic.name).c_str(), statistic.value, std::span(&values, 1)));
    }
  }
}

decid_status decid_model_load(const char* path, decid_model** model) {
  return made(model, "decid_model_load", [&] {
    const std::string name = text_or_empty(path);
    if (path != nullptr && name.empty())
      throw decid::Error(decid::Code::setting_missing, "decid_model_load", "the path is empty",
                         "give a model file, or NULL for the built-in model");
    return std::make_unique<decid_model>(decid::model_or_built_in(name), decid::model_name(name));
  });
}
decid_status decid_model_save(const decid_model* model, const char* path) {
  return guarded([&] {
    const decid_model& saved = given(model, "decid_model_save", "model");
    decid::write_file(path_to_write(path, "decid_model_save"), decid::to_bytes(saved.model));
  });
}
void decid_model_free(decid_model* model) {
  delete model;
}
const decid_protocol* decid_model_protocol(const decid_model* model) {
  return model == nullptr ? nullptr : &model->protocol;
}
const char* decid_model_head(const decid_model* model) {
  return model == nullptr ? nullptr : model->head.c_str();
}
const char* decid_model_sha256(const decid_model* model) {
  return model == nullptr ? nullptr : model->sha256.c_str();
}
size_t decid_model_layers(const decid_model* model) {
  return model == nullptr ? 0 : model->layers.size();
}
const decid_layer* decid_model_layer(const decid_model* model, size_t index) {
  return model == nullptr ? nullptr : at(model->layers, index);
}
size_t decid_model_tensors(const decid_model* model) {
  return model == nullptr ? 0 : model->tensors.size();
}
const decid_tensor* decid_model_tensor(const decid_model* model, size_t index) {
  return model == nullptr ? nullptr : at(model->tensors, index);
}
