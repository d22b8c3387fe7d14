// An unfinished training as a file: the model, its optimiser and its log, and whether it can be resumed.
#pragma once

#include <string>

#include "identify/training/training.hpp"
#include "nn/sgd.hpp"

namespace decid {

/// What the model file of an unfinished training has besides the model.
struct Checkpoint {
  std::string progress;              ///< a text, not empty
  nn::Velocities<float> velocities;  ///< of the optimiser
};

/// Everything that determines the bits of what the training makes. program: "decid 0.2.0".
Origin origin_of(const TrainingSettings& settings, const dataset::TrialSource& source, const std::string& program);

/// The bytes of a checkpoint.
std::string checkpoint_bytes(const TrainingState& state);

/// Reads a checkpoint to resume from. Throws Error, naming what differs, if it was made with another origin or
/// image, or for another protocol; the protocols' names may differ.
TrainingState load_checkpoint(const std::string& path, const Origin& origin, const dataset::ImageSettings& image,
                              const sim::Protocol& protocol);

}  // namespace decid
