// An unfinished training as a file: the model, its optimiser and its log, and whether a training can go on from it.
#pragma once

#include <optional>
#include <string>

#include "identify/training/training.hpp"
#include "nn/training/sgd.hpp"

namespace decid {

/// What the model file of an unfinished training has besides the model.
struct Checkpoint {
  std::string progress;                         ///< a text, not empty
  nn::MomentumBuffers<float> momentum_buffers;  ///< of the optimiser
};

/// Everything that determines the bits of what the training makes. program: "decid 0.2.0"; from: of a fine tuning.
Origin origin_of(const TrainingSettings& settings, const dataset::TrialSource& source, const std::string& program,
                 std::optional<Origin::Start> from = std::nullopt);

/// The bytes of a checkpoint, and what they hold; errors call it `name`.
std::string checkpoint_bytes(const TrainingState& state);
TrainingState state_from_bytes(const std::string& bytes, const std::string& name = "training");

/// What a command is to train.
struct TrainingRequest {
  Origin origin;
  dataset::ImageSettings image;
  sim::Protocol protocol;
  bool more_epochs =
      false;  ///< may go on from a training for fewer epochs, with the schedule of as many as are asked for
};

/// Reads a checkpoint to resume from; more epochs are noted in its origin. Throws Error, naming what differs, unless it
/// is of the request; the protocols' names may differ.
TrainingState load_checkpoint(const std::string& path, const TrainingRequest& request);

struct FinishedTraining {
  TrainingState state;
  bool done;  ///< all that was asked for; otherwise the state to go on from
};
/// The finished model at `path` and its log. If it is of fewer epochs, and the request allows more, a training can go
/// on from it: the log ends with the epoch that was kept then, velocities begin at 0, and its origin says so. Throws
/// Error, naming what differs, if it is not of the request and would be overwritten.
FinishedTraining load_finished(const std::string& path, const TrainingRequest& request);

}  // namespace decid
