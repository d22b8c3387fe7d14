// Files of unfinished trainings: the model, its optimiser and its log, with checks that a training can resume from
// them.
#pragma once

#include <optional>
#include <string>

#include "identify/training/training.hpp"

namespace decid {

/// The contents of an unfinished training's file except the model.
struct Checkpoint {
  std::string progress;                              ///< a text, not empty
  std::vector<std::vector<float>> momentum_buffers;  ///< of the optimiser, per parameter
  std::optional<nn::Network<float>> average{};       ///< of the weights, if the training has one
};

/// Returns everything that determines the bits of the trained model. program: "decid 0.2.0"; from: the start of a fine
/// tuning.
Origin make_origin(const TrainingSettings& settings, const dataset::TrialSource& source, const std::string& program,
                   std::optional<Origin::Start> from = std::nullopt);

/// Returns a training's state as the bytes of a checkpoint. Momentum buffers of a training that has not begun are 0.
std::string checkpoint_bytes(const TrainingState& state);
/// Reads a training's state from these bytes. Throws Error for other bytes, naming `name`.
TrainingState state_from_bytes(const std::string& bytes, const std::string& name = "training");

/// The training that a command requests.
struct TrainingRequest {
  Origin origin;
  dataset::ImageSettings image;
  sim::Protocol protocol;
  /// A training for fewer epochs may be continued, with the schedule of the requested number.
  bool more_epochs = false;
};

/// Reads a checkpoint to resume from; more epochs are noted in its origin. Throws Error, naming the difference, unless
/// it fits the request; the protocols' names may differ.
TrainingState load_checkpoint(const std::string& path, const TrainingRequest& request);

struct FinishedTraining {
  TrainingState state;
  bool done;  ///< the request is complete; false: the training resumes from `state`
};
/// Reads the finished model at `path` and its log. If it has fewer epochs, and the request allows more, a training can
/// continue from it. The log then ends with the epoch that was kept, momentum buffers begin at 0, and the origin
/// records the extension. Throws Error, naming the difference, if it does not fit the request and would be overwritten.
FinishedTraining load_finished(const std::string& path, const TrainingRequest& request);

}  // namespace decid
