// A training that is not done, as a file: the model, its optimiser and its log, and whether it may be gone on with.
#pragma once

#include <string>

#include "identify/training/training.hpp"

namespace decid {

/// Everything that decides the bits of what the training makes. program: "decid 0.2.0".
Origin origin_of(const TrainingSettings& settings, const dataset::TrialSource& source, const std::string& program);

/// The bytes of a checkpoint.
std::string checkpoint_bytes(const TrainingState& state);

/// Reads one to go on with, from `path`. Throws Error, naming what differs, if it was made with another origin or
/// image, or for another protocol; the protocols' names may differ.
TrainingState load_checkpoint(const std::string& path, const Origin& origin, const dataset::ImageSettings& image,
                              const sim::Protocol& protocol);

}  // namespace decid
