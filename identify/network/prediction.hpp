// A model's outputs for many trials from any source.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "base/communicator.hpp"
#include "identify/network/model.hpp"

namespace decid {

using dataset::SwaySink;
/// Gives the sway of trial indices[place] to `take`, for every place: in any order and from many threads.
using Sways = std::function<void(std::span<const int> indices, const SwaySink& take)>;
/// Returns a source of trials in memory: sway(i) gives trial i.
Sways sways_in_memory(std::function<std::span<const float>(int)> sway, double body_height = 1.0);
/// Runs the network over trials in batches. Returns its outputs, trial after trial, which model.head reads. Each call
/// of `sways` requests up to `at_once` trials.
std::vector<float> predict(const Model& model, int trials, int at_once, const Sways& sways);
/// Does the same with ranks that share the trials, unless null. A rank calls `sways` for its own trials; each rank gets
/// all outputs.
std::vector<float> predict(const Model& model, int trials, int at_once, const Sways& sways, Communicator* ranks);

/// Returns the z-scored point estimates that such outputs stand for: scores[trial * parameters + parameter].
std::vector<float> to_scores(const Model& model, std::span<const float> outputs);

/// The outputs for trials of a source, and the parameters that the trials were simulated with.
struct OutputsOf {
  std::vector<float> outputs;
  std::vector<sim::Parameters> truth;
};
/// Computes the outputs of `trials` trials, evenly spread over the part in that epoch. ranks, unless null, share the
/// work; each rank gets all outputs.
OutputsOf compute_outputs(const Model& model, const dataset::TrialSource& source, dataset::Part part, int epoch,
                          int trials, Communicator* ranks = nullptr);

/// The scores of a part of a source's trials, and the parameters that the trials were simulated with.
struct Predicted {
  std::vector<float> scores;
  std::vector<sim::Parameters> truth;
};
/// Computes the scores of epoch 0.
Predicted predict(const Model& model, const dataset::TrialSource& source, dataset::Part part,
                  Communicator* ranks = nullptr);

}  // namespace decid
