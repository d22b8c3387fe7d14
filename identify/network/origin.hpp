// The origin of a model: its training trials and settings. It holds everything that determines the bits of the weights.
// A training can thus be resumed or repeated, and no model is measured on trials that it was trained on.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dataset/source.hpp"

namespace decid {

struct Origin {
  /// The version of the format. Version 1, of decid 0.1, named its trials in a sentence.
  static constexpr int newest_version = 2;

  int version = newest_version;
  std::string program;  ///< "decid 0.2.0"
  std::string preset;
  std::uint64_t seed = 0;  ///< of weights and shuffling
  int epochs = 0, batch = 0;
  double learning_rate = 0.0, momentum = 0.0, weight_decay = 0.0;
  std::string schedule;
  int warmup_epochs = 0;
  std::string architecture;
  dataset::TrialIdentity trials;
  int training_trials = 0, validation_trials = 0;
  int patience = 0;      ///< epochs; 0: the last epoch was kept
  double average = 0.0;  ///< decay of the moving average that the weights are; 0: those of the last step

  /// The model whose weights a fine tuning began with.
  struct Start {
    std::string weights_sha256;
    std::vector<dataset::TrialIdentity> trials;  ///< training trials of this model and of the models before it
    bool operator==(const Start&) const = default;
  };
  std::optional<Start> from;
  /// An extension of a training to more epochs than first planned: up to there it had another schedule.
  struct Extension {
    int after, planned;  ///< epochs
    bool operator==(const Extension&) const = default;
  };
  std::vector<Extension> extensions;

  bool operator==(const Origin&) const = default;
};

/// Returns one line, keys in the order above, in the format of the origin's version.
std::string to_json(const Origin& origin);
/// Reads an origin of any version. Keys that are missing or of another type keep their defaults, so files of other
/// programs can be read. Throws Error for a text that is not a JSON object. `where` names the source.
Origin origin_from_json(const std::string& text, const std::string& where);
/// Lists the settings that differ: "epochs 3 there, 5 here; ...".
std::string difference(const Origin& there, const Origin& here);

/// Returns the start of a fine tuning of a model of this origin. weights_sha256: of that model.
Origin::Start start_from(const Origin& origin, const std::string& weights_sha256);

/// The part of a data set that a model is to be measured on.
enum class Measured { all, training, validation };

/// Returns true if the model was trained on exactly the data set `data`, with its halves for training and validation.
bool trained_on(const Origin& origin, const dataset::TrialIdentity& data);

/// Throws Error if this model, or a model before it, was trained on trials of `data`: trials drawn from the same seed,
/// or the training half of the same data set. Errors call the data `name`. `part` can name a half of that data set: the
/// training half is then allowed on purpose, and the validation half holds no training trials.
void require_not_trained_on(const Origin& origin, const dataset::TrialIdentity& data, Measured part,
                            const std::string& name);

}  // namespace decid
