// The state from which nn::fit resumes, and its file: a network's (nn/network_file.hpp) with further tensors. Not
// installed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nn/fit.hpp"
#include "nn/training/loop.hpp"

namespace decid::nn {

struct FitState {
  OptimiserState optimiser;
  std::vector<FitEpoch> log;
  LoopPosition at;
  std::optional<Network<float>> average, best;
  int best_epoch = 0;  ///< 0: none yet
};

/// Writes a checkpoint. description: of everything that determines the bits. Throws Error if the file cannot be
/// written.
void save_checkpoint(const Network<float>& network, const FitState& state, const std::string& description,
                     const std::string& path);
/// Reads a checkpoint. Throws Error, and changes nothing, unless the file is of the same network and description.
void load_checkpoint(Network<float>& network, FitState& state, const std::string& description, const std::string& path);

}  // namespace decid::nn
