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
#include "identify/network/familiarity.hpp"
#include "identify/network/head.hpp"
#include "identify/network/origin.hpp"
#include "identify/training/log.hpp"
#include "nn/network.hpp"

namespace decid {

struct Model {
  /// Of its trials. images() and the network were made for its experiment: another one needs another model.
  sim::Protocol protocol;
  dataset::RowScaling rows;  ///< empty unless image().standardize_rows
  dataset::TargetScaling targets;
  nn::Network<float> network;
  const Head* head;  ///< what the network's outputs mean; outlives the model
  Familiarity familiarity;
  Recalibration recalibration;  ///< of the head's distributions
  Origin origin;
  std::vector<EpochLog> log;  ///< of its finished training; empty: not known

  /// A fresh network for these images; weights are not initialised. Throws Error if the architecture does not fit the
  /// images or the head, or if the images fold cycles that the protocol does not play.
  Model(sim::Protocol protocol, dataset::ImageSettings image, const std::string& architecture,
        const Head& head = point_head());

  /// What is identified, in the ranges of the protocol's body.
  const sim::ParameterTable& parameters() const { return ranges_; }
  /// The parameters that one trial's outputs stand for. Throws Error unless there are as many as the network has.
  sim::Parameters decode(std::span<const float> outputs) const;
  /// What they say of these parameters, recalibrated; empty if the head gives point estimates alone. ranges: of
  /// parameters(), or what they are for another body. Throws Error as decode() does.
  std::optional<ParameterDistribution> distribution(std::span<const float> outputs,
                                                    const sim::ParameterTable& ranges) const;
  std::optional<ParameterDistribution> distribution(std::span<const float> outputs) const {
    return distribution(outputs, parameters());
  }
  bool gives_distribution() const { return head->gives_distribution(); }
  /// Mean squared error of the z-scored parameters on the validation trials, at the epoch that was kept; empty if the
  /// log is not known. Guessing the middle of the ranges has 1.
  std::optional<double> validation_mse() const;

  /// Draws the images of trials.
  const dataset::ImageMaker& images() const { return images_; }
  const dataset::ImageSettings& image() const { return images_.settings(); }
  /// How a trial becomes the network's input; refers to this model.
  dataset::Encoding encoding() const { return {images_, rows}; }
  /// The image of a trial as the network sees it, row scaling applied. sway: of protocol.samples() values;
  /// image_values: images().shape().size(). Throws Error for a wrong number of either.
  void make_input(const dataset::Sway& sway, std::span<float> image_values) const {
    encoding().encode(sway, image_values);
  }
  /// What images() drew as the network sees it, in place: row scaling applied. image_values: those of one image,
  /// images().shape().size().
  void scale(std::span<float> image_values) const {
    if (!rows.mean.empty()) rows.apply(image_values, images_.shape().columns);
  }

 private:
  void require_outputs(std::span<const float> outputs) const;

  sim::ParameterTable ranges_;
  dataset::ImageMaker images_;
};

struct Checkpoint;  // identify/training/checkpoint.hpp

/// The bytes of a model file; of a checkpoint's unless that is null. They hold their own hash (nn::content_sha256).
std::string to_bytes(const Model& model, const Checkpoint* checkpoint = nullptr);

/// Throws Error for a damaged file (a hash is checked where there is one), or one that is not a decid model. Unless
/// `checkpoint` is null the file must be one; what it has besides the model goes there.
Model model_from_bytes(std::string_view bytes, const std::string& where, Checkpoint* checkpoint = nullptr);
/// The model file at `path`. Throws Error if it cannot be read, and as model_from_bytes does.
Model load_model(const std::filesystem::path& path);

/// The model inside the program.
Model built_in_model();
/// The model file at `path` (load_model), or the built-in one if the path is empty.
Model model_or_built_in(const std::string& path);
/// What people call the model of model_or_built_in(path): the path, or "built-in model".
std::string model_name(const std::string& path);

/// Throws Error if the trials of `file` are of another experiment than the model, which is called `name`.
void require_same_experiment(const Model& model, const std::string& name, const sim::Protocol& data,
                             const std::string& file);
/// How the vestibular noise of a data set's trials differs from that of the model's training, for people; empty if it
/// does not. If it does, Nv means something else.
std::string noise_difference(const sim::Protocol& model, const sim::Protocol& data);

}  // namespace decid
