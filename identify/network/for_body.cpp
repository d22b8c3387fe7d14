// A model's answers for another body: see for_body.hpp.
#include "identify/network/for_body.hpp"

#include "base/error.hpp"
#include "base/text.hpp"
#include "sim/segments.hpp"

namespace decid {
namespace {

constexpr double height_margin = 0.01;

sim::Parameters times_mgh(const sim::ParameterTable& table, double ratio, sim::Parameters parameters) {
  for (std::size_t p = 0; p < table.size(); ++p)
    if (table[p].scales_with_mgh) parameters[p] *= ratio;
  return parameters;
}

double mgh_over(const ForBody& body, const Model& model) {
  return body.protocol.experiment.body.mgh() / model.protocol.experiment.body.mgh();
}

}  // namespace

sim::Parameters ForBody::from_model(const Model& model, const sim::Parameters& parameters) const {
  return times_mgh(ranges, mgh_over(*this, model), parameters);
}

sim::Parameters ForBody::to_model(const Model& model, const sim::Parameters& parameters) const {
  return times_mgh(ranges, 1.0 / mgh_over(*this, model), parameters);
}

bool knows_body(const Model& model, const sim::Body& body) {
  const double height = body.height_over(model.protocol.experiment.body);
  const sim::Heights& known = model.protocol.heights;
  return height >= known.low * (1.0 - height_margin) && height <= known.high * (1.0 + height_margin);
}

bool knows_experiment(const Model& model, const sim::Experiment& experiment) {
  return knows_body(model, experiment.body) && experiment.is_same_but_body(model.protocol.experiment);
}

ForBody for_trials(const Model& model, const std::string& name, const sim::Protocol& trials, const std::string& file) {
  const sim::Body& body = trials.experiment.body;
  if (body == model.protocol.experiment.body || !knows_body(model, body)) {
    require_same_experiment(model, name, trials, file);
    return for_body(model, name, {});
  }
  sim::Protocol same_body = trials;
  same_body.experiment.body = model.protocol.experiment.body;
  require_same_experiment(model, name, same_body, file);
  return for_body(model, name, body);
}

ForBody for_body(const Model& model, const std::string& name, const std::optional<sim::Body>& body) {
  ForBody found{model.protocol, model.parameters()};
  if (!body) return found;
  found.assumed = false;
  found.protocol.experiment.body = *body;
  found.protocol.validate();
  found.ranges = found.protocol.ranges();
  found.height = body->height_over(model.protocol.experiment.body);
  if (knows_body(model, *body)) return found;
  const sim::Heights& known = model.protocol.heights;
  const double metre = sim::make_body(sim::make_segments({.height_m = 1.0})).com_height_m;
  const double model_m = model.protocol.experiment.body.com_height_m / metre;
  throw Error(Code::setting_out_of_range, "body",
              format("height %.3g m is outside the range of %s (%.3g to %.3g m)", body->com_height_m / metre,
                     name.c_str(), known.low * model_m, known.high * model_m),
              "fit the recording (decid fit), or train a model on a protocol with body_heights");
}

}  // namespace decid
