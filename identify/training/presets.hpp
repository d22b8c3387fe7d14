// Ready-made networks: architecture, image and training settings under one name, for decid train --preset.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "dataset/image/image.hpp"
#include "nn/training/sgd.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid {

/// What a preset leaves out is as here; an image left out is the paper's.
struct Preset {
  std::string name;
  std::string description;
  std::string architecture;
  std::string head = "point";  ///< see head_named(): the last layer has as many outputs as it needs
  dataset::ImageSettings image{};
  int epochs = 30;
  int batch = 64;
  double learning_rate = 0.01;
  nn::SgdSettings sgd{};
  std::string schedule = "cosine";  ///< see nn::Schedule
  int warmup_epochs = 0;
};

std::span<const Preset> presets();
/// The preset's image for trials of a protocol. Images that fold whole cycles into one window fit every protocol: its
/// cycles are the windows, up to the same frequency, in 64 to 1024 rows; cycles that are not a whole number of samples,
/// too long, too many, or of a length that is not transformed, are one window, as many as fit, and not folded. Folded
/// time series likewise, but of eight cycles at most; their blocks are as long in seconds, longer where there would be
/// more than 2048. Other images are as they are.
dataset::ImageSettings image_for(const Preset& preset, const sim::Protocol& protocol);

/// The preset with a head of that name; the last layer of its network has the outputs that the head needs. Throws Error
/// as head_named() of `where`.
Preset with_head(Preset preset, const std::string& head, std::size_t parameters, const std::string& where);

/// Throws Error, listing the presets, if there is none of that name.
const Preset& preset_named(const std::string& name);

}  // namespace decid
