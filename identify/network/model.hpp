// A trained model: the network with everything that identification needs - protocol, image settings, row scaling,
// target scaling - in one safetensors file.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/feed.hpp"
#include "dataset/sets/dataset.hpp"
#include "identify/network/distribution.hpp"
#include "identify/network/head.hpp"
#include "identify/network/ood_detector.hpp"
#include "identify/network/origin.hpp"
#include "identify/training/log.hpp"
#include "nn/network.hpp"

namespace decid {

struct Model {
  /// Protocol of the model's trials. images() and the network fit only its experiment.
  sim::Protocol protocol;
  dataset::RowScaling rows;  ///< empty unless image().standardize_rows
  dataset::TargetScaling targets;
  nn::Network<float> network;
  const Head* head;  ///< what the network's outputs mean; outlives the model
  OodDetector ood_detector;
  Recalibration recalibration;  ///< of the head's distributions
  Origin origin;
  std::vector<EpochLog> log;  ///< epochs of its finished training; empty: unknown

  /// Creates a new network for these images; weights are not initialised. Throws Error if the architecture does not fit
  /// the images or the head, or if the images average cycles that the protocol does not play.
  Model(sim::Protocol protocol, dataset::ImageSettings image, const std::string& architecture,
        const Head& head = point_head());

  /// Returns the parameters that the model identifies, in the ranges of the protocol's body.
  const sim::ParameterTable& parameters() const { return ranges_; }
  /// Returns the parameters that one trial's outputs stand for. Throws Error unless there are as many as the network
  /// has.
  sim::Parameters decode(std::span<const float> outputs) const;
  /// Returns the recalibrated distribution of the parameters; empty if the head gives only point estimates. ranges:
  /// parameters(), or the ranges of another body. Throws Error as decode() does.
  std::optional<ParameterDistribution> distribution(std::span<const float> outputs,
                                                    const sim::ParameterTable& ranges) const;
  std::optional<ParameterDistribution> distribution(std::span<const float> outputs) const {
    return distribution(outputs, parameters());
  }
  bool gives_distribution() const { return head->gives_distribution(); }
  /// Returns the mean squared error of the z-scored parameters on the validation trials, at the epoch that was kept;
  /// empty if there is no log. Guessing the middle of the ranges gives 1.
  std::optional<double> validation_mse() const;

  /// Returns the maker of the network's inputs.
  const dataset::ImageMaker& images() const { return images_; }
  const dataset::ImageSettings& image() const { return images_.settings(); }
  /// Returns the encoding of trials as network inputs; it refers to this model.
  dataset::Encoding encoding() const { return {images_, rows}; }
  /// Computes the network input of a trial, row scaling applied. sway: protocol.samples() values; image_values:
  /// images().shape().size(). Throws Error for a wrong number of either.
  void make_input(const dataset::Sway& sway, std::span<float> image_values) const {
    encoding().encode(sway, image_values);
  }
  /// Applies row scaling in place to an image made by images(). image_values: one image, images().shape().size()
  /// values.
  void scale(std::span<float> image_values) const {
    if (!rows.mean.empty()) rows.apply(image_values, images_.shape().columns);
  }

 private:
  void require_outputs(std::span<const float> outputs) const;

  sim::ParameterTable ranges_;
  dataset::ImageMaker images_;
};

struct Checkpoint;  // identify/training/checkpoint.hpp

/// Returns the bytes of a model file, or of a checkpoint file unless `checkpoint` is null. They hold their own hash
/// (nn::content_sha256).
std::string to_bytes(const Model& model, const Checkpoint* checkpoint = nullptr);

/// Reads a model. Throws Error for a damaged file (a hash is checked if there is one), or a file that is not a decid
/// model. Unless `checkpoint` is null the file must be a checkpoint; its other contents go there.
Model model_from_bytes(std::string_view bytes, const std::string& where, Checkpoint* checkpoint = nullptr);
/// Reads the model file at `path`. Throws Error if it cannot be read, and as model_from_bytes does.
Model load_model(const std::filesystem::path& path);

/// Returns the model inside the program.
Model built_in_model();
/// Returns the model of the file at `path` (load_model), or the built-in model if the path is empty.
Model model_or_built_in(const std::string& path);
/// Returns the display name of the model of model_or_built_in(path): the path, or "built-in model".
std::string model_name(const std::string& path);

/// Throws Error if the trials of `file` are of another experiment than the model, which is called `name`.
void require_same_experiment(const Model& model, const std::string& name, const sim::Protocol& data,
                             const std::string& file);
/// Describes how the vestibular noise of a data set's trials differs from the model's training; empty if it does not.
/// If it differs, Nv means something else.
std::string noise_difference(const sim::Protocol& model, const sim::Protocol& data);

}  // namespace decid
