// Ready-made networks: architecture, image and training settings under one name, for decid train --preset.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "dataset/image/image.hpp"
#include "nn/training/optimiser.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid {

/// A preset. Settings that it leaves out have the defaults below; the default image is the paper's.
struct Preset {
  std::string name;
  std::string description;
  std::string architecture;
  std::string head = "point";  ///< see head_named(): it determines the number of outputs of the last layer
  dataset::ImageSettings image{};
  int epochs = 30;
  int batch = 64;
  double learning_rate = 0.01;
  nn::SgdOptions sgd{};
  std::string schedule = "cosine";  ///< see nn::Schedule
  int warmup_epochs = 0;
};

std::span<const Preset> presets();
/// Returns the preset's image settings for trials of a protocol. Images that average whole cycles into one window fit
/// every protocol: its cycles are the windows, up to the same frequency, in 64 to 1024 rows. Cycles are not averaged if
/// they are not a whole number of samples, too long, too many, or of a length without a transform. Then as many cycles
/// as fit form one window. Cycle-averaged time series follow the same rules with eight cycles at most. Their blocks
/// have the same length in seconds, or longer where there would be more than 2048. Other images do not change.
dataset::ImageSettings image_for(const Preset& preset, const sim::Protocol& protocol);

/// Returns the preset with a head of that name; the last layer of its network has the outputs of the head. Throws Error
/// as head_named() of `where`.
Preset with_head(Preset preset, const std::string& head, std::size_t parameters, const std::string& where);

/// Returns the preset of that name. Throws Error, listing the presets, if there is none.
const Preset& preset_named(const std::string& name);

}  // namespace decid
