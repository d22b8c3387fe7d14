// The log of a training, one line per epoch: a CSV file next to the model, and JSON inside of model files.
#pragma once

#include <string>
#include <vector>

namespace decid {

/// One line of the log. MSE: the loss of the model's head, a trial and parameter, which is a mean squared error.
/// MATLAB's regression loss is half the sum over the parameters.
struct EpochLog {
  int epoch = 0;                ///< from 1
  double training_mse = 0.0;    ///< mean over the epoch's batches, as they were trained
  double validation_mse = 0.0;  ///< with running statistics, after the epoch
  double learning_rate = 0.0;   ///< of the epoch's last step

  bool operator==(const EpochLog&) const = default;
};

/// The progress within an epoch.
struct EpochPart {
  int trials = 0;         ///< that it has seen, whole batches; 0: the epoch has not begun
  double loss_sum = 0.0;  ///< of these

  bool operator==(const EpochPart&) const = default;
};

std::string log_csv(const std::vector<EpochLog>& log, std::size_t parameters);

/// Returns the epoch of the lowest validation MSE, the first of equals; 0 if there is none yet.
int best_epoch(const std::vector<EpochLog>& log);
/// Returns the epoch whose weights the model has: with patience the best one, else the last. Throws std::out_of_range
/// if there is none.
const EpochLog& kept_epoch(const std::vector<EpochLog>& log, int patience);

/// A list of [epoch, training MSE, validation MSE, learning rate]; with a part of an epoch behind it, unless that has
/// not begun, {"epochs": the list, "trials": .., "loss_sum": ..}.
std::string to_json(const std::vector<EpochLog>& log, const EpochPart& part = {});
/// Throws Error, naming `where`, unless the epochs are numbered from 1 on.
std::vector<EpochLog> log_from_json(const std::string& text, const std::string& where, EpochPart* part = nullptr);

}  // namespace decid
