// Where a model comes from: what it was trained on and how. Everything that determines the bits of its weights is here,
// so that a training can be resumed or repeated, and no model is measured on trials that it was trained on.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dataset/source.hpp"

namespace decid {

struct Origin {
  /// The version of its form. Version 1, of decid 0.1, named its trials in a sentence.
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
  int patience = 0;  ///< epochs; 0: the last epoch was kept

  /// The model whose weights a fine tuning began with.
  struct Start {
    std::string weights_sha256;
    std::vector<dataset::TrialIdentity> trials;  ///< that it was trained on, and those of the models before it
    bool operator==(const Start&) const = default;
  };
  std::optional<Start> from;
  /// A training that went on to more epochs than it was begun for: its schedule was another one up to there.
  struct Extension {
    int after, planned;  ///< epochs
    bool operator==(const Extension&) const = default;
  };
  std::vector<Extension> extensions;

  bool operator==(const Origin&) const = default;
};

/// One line, keys in the order above, in the form of the origin's version.
std::string to_json(const Origin& origin);
/// Of any version. What is left out, or of another type, keeps its default, so files of other programs can be read.
/// Throws Error for a text that is not a JSON object. `where` names the source.
Origin origin_from_json(const std::string& text, const std::string& where);
/// Which settings differ, for people: "epochs 3 there, 5 here; ...".
std::string difference(const Origin& there, const Origin& here);

/// What a fine tuning of a model of this origin begins with. weights_sha256: of that model.
Origin::Start start_from(const Origin& origin, const std::string& weights_sha256);

/// The part of a data set that a model is to be measured on.
enum class Measured { all, training, validation };

/// Whether `data` is the very data set that the model was trained on, its halves for training and validation.
bool trained_on(const Origin& origin, const dataset::TrialIdentity& data);

/// Throws Error if the trials of `data`, which people know as `name`, are among those that the model was trained on:
/// or the models before it were, drawn from the same seed, or the training half of the same data set. Its halves may be
/// asked for by name: the training half is meant then, and no trial of the validation half was trained on.
void require_not_trained_on(const Origin& origin, const dataset::TrialIdentity& data, Measured part,
                            const std::string& name);

}  // namespace decid
