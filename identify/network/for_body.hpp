// A model's answers for another body than its own. What a controller does to a body depends on its parameters over
// m g h and on the body's height; so the network is shown the height, and its answers are taken times the body's m g h.
#pragma once

#include <optional>
#include <string>

#include "identify/network/model.hpp"

namespace decid {

struct ForBody {
  sim::Protocol protocol;      ///< the model's, with this body
  sim::ParameterTable ranges;  ///< of this body
  double height = 1.0;         ///< over the model's body's (dataset::Sway)
  bool assumed = true;         ///< no body is known: it is the model's own

  /// What the model says of its own body, of this one.
  sim::Parameters from_model(const Model& model, const sim::Parameters& parameters) const;
  /// The other way.
  sim::Parameters to_model(const Model& model, const sim::Parameters& parameters) const;
};

/// Empty: the model's own body. Throws Error, which calls the model `name`, unless the model knows bodies of that
/// height: those of its protocol's `heights`, and a hundredth more at either end.
ForBody for_body(const Model& model, const std::string& name, const std::optional<sim::Body>& body);
/// Whether for_body() takes the body.
bool knows_body(const Model& model, const sim::Body& body);
/// Whether the model's network answers to recordings of this experiment: its stimulus and rate, of a body that it
/// knows.
bool knows_experiment(const Model& model, const sim::Experiment& experiment);
/// Of a data set's trials, in `file`. Throws Error if they are of another experiment than the model, but for the body,
/// and as for_body() does.
ForBody for_trials(const Model& model, const std::string& name, const sim::Protocol& trials, const std::string& file);

}  // namespace decid
