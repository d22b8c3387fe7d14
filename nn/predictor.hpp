// Computes a trained network's outputs for images.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "nn/inference.hpp"

namespace decid::nn {

template <class T>
class BatchExecutor;
class SingleExecutor;

/// The memory of one thread's predictions. Several predictors share one Inference; a predictor's calls must come one
/// after the other. Up to 8 images go through the network one after the other, more of them in batches of up to 64.
/// After construction only the layers allocate that SingleExecutor (nn/single.hpp) and BatchExecutor
/// (nn/training/batch.hpp) name. An image's outputs have the same bits for any number of images and any other images in
/// the batch.
class Predictor {
 public:
  /// `max_batch`: the number of images that run() often gets; it processes more in parts of this size.
  Predictor(std::shared_ptr<const Inference<float>> inference, int max_batch);
  /// Copies the current weights of a network.
  Predictor(const Network<float>& network, int max_batch)
      : Predictor(std::make_shared<const Inference<float>>(network), max_batch) {}
  Predictor(Predictor&&) noexcept;
  Predictor& operator=(Predictor&&) noexcept;
  ~Predictor();

  const Inference<float>& inference() const { return *inference_; }
  /// Returns the inference for the predictor of another thread.
  const std::shared_ptr<const Inference<float>>& shared_inference() const { return inference_; }
  /// Returns the number of `features` values per image; 0 if the network has none: see Inference.
  int feature_count() const { return inference_->feature_count(); }
  /// Returns the bytes of this predictor, without the memory that the predictors of one Inference share.
  std::size_t memory_bytes() const;

  /// Computes outputs. `images`: n images one after the other, each channel-major, input_shape().size() values.
  /// `outputs`: n times output_shape().size() values, image after image. `features`: what the last layer reads, n times
  /// feature_count() values, channel-major; or empty. Throws Error for spans that do not fit together.
  void run(std::span<const float> images, std::span<float> outputs, std::span<float> features = {});

  /// Computes the output of layer `layer`, counted from 0, for one image, channel-major. As BatchNorm is folded into
  /// the convolution before it, that convolution's output is the normalised one, before its ReLU. Throws Error if there
  /// is no such layer, or for spans of another size.
  void activation(std::size_t layer, std::span<const float> image, std::span<float> values);

 private:
  void run_batch(std::span<const float> images, std::span<float> outputs, std::span<float> features);

  std::shared_ptr<const Inference<float>> inference_;
  std::unique_ptr<SingleExecutor> single_;
  std::unique_ptr<BatchExecutor<float>> batch_;  // unless all batches are of a few images
};

}  // namespace decid::nn
