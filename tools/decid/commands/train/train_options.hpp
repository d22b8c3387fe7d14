// The options of decid train, and the settings of a training that they mean.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "identify/result.hpp"
#include "identify/training/training.hpp"
#include "tools/decid/command.hpp"

namespace decid::tools {

struct TrainOptions {
  CommonOptions common;
  std::string data, preset = "best", architecture_file, image_file, from, report, output;
  ProtocolOptions protocol;
  bool stream = false, resume = false, usr1 = false;
  int stream_trials = 25600, validation_trials = 1000, patience = 0;
  std::uint64_t seed = 1;
  // Unset: the preset's.
  std::optional<std::string> head;
  std::optional<int> epochs, batch;
  std::optional<double> learning_rate, momentum, weight_decay;
  double average = 0;
  std::optional<std::string> schedule;
  Call call = {};  ///< for the JSON and the page, from the options above
};

/// Adds the options, which stay at `options` until the command has run.
void add_train_options(const Command& command, TrainOptions& options);

/// Returns the preset's settings, changed by the options. Throws Error for a preset, head, schedule or file that is
/// none.
TrainingSettings settings_from(const TrainOptions& options);

}  // namespace decid::tools
