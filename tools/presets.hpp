// Ready-made networks: architecture, image and training settings under one name, for decid train --preset.
#pragma once

#include <string>
#include <vector>

#include "dataset/image.hpp"
#include "nn/network.hpp"

namespace decid::tools {

struct Preset {
  std::string name;
  std::string description;
  std::string architecture;
  dataset::ImageSettings image;
  int epochs = 30;
  int batch = 64;
  double learning_rate = 0.01;
  nn::SgdSettings sgd;
  std::string schedule = "cosine";  ///< see nn::Schedule
  int warmup_epochs = 0;
};

const std::vector<Preset>& presets();
/// Throws Error listing the presets if there is none of that name.
const Preset& preset_named(const std::string& name);

}  // namespace decid::tools
