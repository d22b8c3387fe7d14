// A trained network's outputs for images: see predictor.hpp.
#include "nn/predictor.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "nn/single.hpp"
#include "nn/training/batch.hpp"

namespace decid::nn {
namespace {

constexpr int few_images = 8;  // up to half a block of lanes, one after the other is faster
constexpr int max_at_once = 64;

/// The part of `values` that belongs to images first .. first + count - 1 of `images`; empty if `values` is.
template <class T>
std::span<T> part(std::span<T> values, std::size_t images, std::size_t first, std::size_t count) {
  const std::size_t size = values.size() / images;
  return values.subspan(first * size, count * size);
}

}  // namespace

Predictor::Predictor(std::shared_ptr<const Inference<float>> inference, int max_batch)
    : inference_(std::move(inference)), single_(std::make_unique<SingleExecutor>(*inference_)) {
  if (max_batch < 1)
    throw Error(Code::setting_out_of_range, "predictor", "has a largest batch of " + std::to_string(max_batch),
                "give at least 1");
  if (max_batch > few_images)
    batch_ =
        std::make_unique<BatchExecutor<float>>(*inference_, std::min({max_batch, max_at_once, lanes * thread_count()}));
}

Predictor::Predictor(Predictor&&) noexcept = default;
Predictor& Predictor::operator=(Predictor&&) noexcept = default;
Predictor::~Predictor() = default;

std::size_t Predictor::memory_bytes() const {
  return single_->memory_bytes() + (batch_ ? batch_->memory_bytes() : 0);
}

void Predictor::run(std::span<const float> images, std::span<float> outputs, std::span<float> features) {
  const auto values = static_cast<std::size_t>(inference_->input_shape().size());
  const auto size = static_cast<std::size_t>(inference_->output_shape().size());
  const auto feature_size = static_cast<std::size_t>(feature_count());
  const std::size_t count = images.size() / values;
  if (images.size() != count * values || outputs.size() != count * size)
    throw Error(Code::size_mismatch, "predictor",
                "got images of " + std::to_string(images.size()) + " values and room for " +
                    std::to_string(outputs.size()) + " outputs where an image has " + std::to_string(values) + " and " +
                    std::to_string(size),
                "give spans of those sizes, times the number of images");
  if (!features.empty() && (feature_size == 0 || features.size() != count * feature_size))
    throw Error(Code::size_mismatch, "predictor",
                "got room for " + std::to_string(features.size()) + " features where " + std::to_string(count) +
                    " images have " + std::to_string(feature_size) + " each",
                "give a span of that size, or none");
  const auto at_once = static_cast<std::size_t>(batch_ ? batch_->max_batch() : 1);
  const bool few = !batch_ || count <= few_images;
  for (std::size_t first = 0; first < count; first += few ? 1 : at_once) {
    const std::size_t here = few ? 1 : std::min(at_once, count - first);
    const auto images_here = part(images, count, first, here);
    const auto outputs_here = part(outputs, count, first, here), features_here = part(features, count, first, here);
    few ? single_->run(images_here, outputs_here, features_here) : run_batch(images_here, outputs_here, features_here);
  }
}

void Predictor::run_batch(std::span<const float> images, std::span<float> outputs, std::span<float> features) {
  const std::size_t count = images.size() / static_cast<std::size_t>(inference_->input_shape().size());
  batch_->set_batch(static_cast<int>(count));
  with_team([&] {
    parallel_for(static_cast<int>(count),
                 [&](int i) { batch_->input().load(i, part(images, count, static_cast<std::size_t>(i), 1)); });
    batch_->forward();
  });
  for (std::size_t i = 0; i < count; ++i) {
    batch_->output().store(static_cast<int>(i), part(outputs, count, i, 1));
    if (!features.empty()) batch_->features().store(static_cast<int>(i), part(features, count, i, 1));
  }
}

void Predictor::activation(std::size_t layer, std::span<const float> image, std::span<float> values) {
  const std::vector<Step<float>>& steps = inference_->steps();
  if (layer >= steps.size())
    throw Error(Code::setting_out_of_range, "activation",
                "of layer " + std::to_string(layer) + " where there are " + std::to_string(steps.size()) + " layers",
                "count from 0");
  if (image.size() != static_cast<std::size_t>(inference_->input_shape().size()) ||
      values.size() != static_cast<std::size_t>(steps[layer].dst.size()))
    throw Error(Code::size_mismatch, "activation", "has an image or room of another size",
                "give input_shape().size() values and room for dst_shape().size()");
  single_->activation(layer, image, values);
}

}  // namespace decid::nn
