// A trained model: the network with everything that identification needs - protocol, image settings, row scaling,
// target scaling - in one safetensors file.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "dataset/feed.hpp"
#include "dataset/sets/dataset.hpp"
#include "identify/familiarity.hpp"
#include "nn/network.hpp"
#include "nn/sgd.hpp"

namespace decid {

struct Model {
  sim::Protocol protocol;
  dataset::ImageSettings image;
  dataset::RowScaling rows;  ///< empty unless image.standardize_rows
  dataset::TargetScaling targets;
  nn::Network<float> network;
  Familiarity familiarity;
  std::string origin;  ///< how it was trained: a JSON text, for people

  /// A fresh network for these images; weights are not initialised. Throws Error if the architecture does not fit the
  /// images, or if these fold cycles that the protocol does not play.
  Model(sim::Protocol protocol, dataset::ImageSettings image, const std::string& architecture);

  /// Makes the images of trials into the network's input; immutable apart from the network.
  const dataset::ImageMaker& images() const { return images_; }
  dataset::Encoding encoding() const { return {images_, rows}; }
  /// The image of a trial as the network sees it, row scaling applied.
  void make_input(std::span<const float> sway_rad, std::span<float> image_values) const {
    encoding().encode(sway_rad, image_values);
  }

 private:
  dataset::ImageMaker images_;
};

/// What a model file of a training that is not done has besides the model.
struct Checkpoint {
  std::string progress;              ///< a text, not empty
  nn::Velocities<float> velocities;  ///< of the optimiser
};

/// The bytes of a model file; of a checkpoint's unless that is null.
std::string to_bytes(const Model& model, const Checkpoint* checkpoint = nullptr);

/// Throws Error for a damaged file, or one that is no decid model. Unless `checkpoint` is null the file
/// must be one, and what it has besides the model goes there.
Model model_from_bytes(std::string_view bytes, const std::string& where, Checkpoint* checkpoint = nullptr);
Model load_model(const std::filesystem::path& path);

/// The model inside the program.
Model built_in_model();
/// The model file at `path`, or the built-in one if the path is empty.
Model model_or_built_in(const std::string& path);
/// How people call it.
std::string model_name(const std::string& path);

/// Throws Error if the trials of `file` are of another experiment than the model, which is called `name`.
void require_same_experiment(const Model& model, const std::string& name, const sim::Protocol& data,
                             const std::string& file);
/// What of the vestibular noise differs between the trials of a data set and those that the model was trained on, for
/// people; empty if nothing does. Nv means something else then.
std::string noise_difference(const sim::Protocol& model, const sim::Protocol& data);

/// Runs the network over trials in batches: outputs[trial * 7 + parameter], z-scored. `sways` is asked for up to
/// `at_once` trials at a time: it calls take(place, sway_rad) for trial indices[place], in any order and from many
/// threads.
using dataset::TakeSway;
using Sways = std::function<void(std::span<const int> indices, const TakeSway& take)>;
/// For trials in memory: sway(i) gives trial i.
Sways sways_in_memory(std::function<std::span<const float>(int)> sway);
std::vector<float> predict(const Model& model, int trials, int at_once, const Sways& sways);

}  // namespace decid
