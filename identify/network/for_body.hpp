// A model's answers for another body than its own. The effect of a controller on a body depends on its parameters over
// m g h and on the body's height. Therefore the height is an input of the network, and its answers are multiplied by
// the body's m g h.
#pragma once

#include <optional>
#include <string>

#include "identify/network/model.hpp"

namespace decid {

struct ForBody {
  sim::Protocol protocol;      ///< the model's, with this body
  sim::ParameterTable ranges;  ///< of this body
  double height = 1.0;         ///< over the model's body's (dataset::Sway)
  bool assumed = true;         ///< no body was given: it is the model's own

  /// Converts parameters of the model's body to this body.
  sim::Parameters from_model(const Model& model, const sim::Parameters& parameters) const;
  /// Converts parameters of this body to the model's body.
  sim::Parameters to_model(const Model& model, const sim::Parameters& parameters) const;
};

/// Returns the plan for a body; empty: the model's own body. Throws Error, which calls the model `name`, unless the
/// height lies in the protocol's `heights`, extended by a hundredth at either end.
ForBody for_body(const Model& model, const std::string& name, const std::optional<sim::Body>& body);
/// Returns true if for_body() accepts the body.
bool knows_body(const Model& model, const sim::Body& body);
/// Returns true if the model's network covers recordings of this experiment: the same stimulus and rate, and a body
/// that for_body() accepts.
bool knows_experiment(const Model& model, const sim::Experiment& experiment);
/// Returns the plan for the trials of a data set in `file`. Throws Error if the experiment, except the body, differs
/// from the model's, and as for_body() does.
ForBody for_trials(const Model& model, const std::string& name, const sim::Protocol& trials, const std::string& file);

}  // namespace decid
