// Identification and fits in C.
#include <cmath>
#include <limits>

#include "base/setting.hpp"
#include "bindings/c/handles.hpp"
#include "identify/compared_controllers.hpp"
#include "sim/segments.hpp"

using namespace decid::c;

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

decid::recording::Detrend detrend_of(int detrend, const char* where) {
  switch (detrend) {
    case DECID_DETREND_NONE:
      return decid::recording::Detrend::none;
    case DECID_DETREND_OFFSET:
      return decid::recording::Detrend::offset;
    case DECID_DETREND_LINEAR:
      return decid::recording::Detrend::linear;
  }
  throw decid::Error(decid::Code::setting_unknown, where, decid::format("there is no detrending %d", detrend),
                     "give a value of decid_detrend");
}

/// Converts the options that identify and fit share.
template <class Options>
decid::recording::TrialOptions trial_options(const Options& asked, const char* where) {
  decid::recording::TrialOptions options;
  if (!std::isnan(asked.begin_s)) options.start_s = asked.begin_s;
  options.detrend = detrend_of(asked.detrend, where);
  return options;
}

template <class Found>
void describe(decid_parameter& parameter, const Found& found, int quantity, double mgh) {
  const auto interval = [&](double probability, double(&limits)[2]) {
    limits[0] = found.quantile(quantity, 0.5 * (1.0 - probability));
    limits[1] = found.quantile(quantity, 1.0 - 0.5 * (1.0 - probability));
  };
  parameter.sd = found.stddev(quantity);
  interval(0.5, parameter.interval50);
  interval(0.9, parameter.interval90);
  for (int end = 0; end < 2; ++end) parameter.normalized_interval90[end] = parameter.interval90[end] / mgh;
}

decid_parameter find_parameter(const char* name, const char* unit, double value) {
  return {name,
          unit,
          unknown,
          unknown,
          value,
          unknown,
          {unknown, unknown},
          {unknown, unknown},
          unknown,
          {unknown, unknown},
          unknown,
          unknown};
}

/// mgh of a value that has no meaning over it.
constexpr double no_mgh = unknown;

std::vector<decid_parameter> parameters_of(const decid::RecordingResult& result,
                                           const decid::sim::ParameterTable& ranges, const decid::sim::Body& body) {
  std::vector<decid_parameter> list;
  for (std::size_t p = 0; p < ranges.size(); ++p) {
    const decid::sim::ParameterInfo& info = ranges[p];
    const double mgh = info.scales_with_mgh ? body.mgh() : no_mgh;
    decid_parameter& parameter =
        list.emplace_back(find_parameter(info.name.c_str(), info.unit.c_str(), result.estimate.parameters[p]));
    parameter.low = info.low;
    parameter.high = info.high;
    parameter.normalized = parameter.value / mgh;
    use_distribution(result, [&](const auto& found) { describe(parameter, found, static_cast<int>(p), mgh); });
  }
  return list;
}

/// Adds the quantities that a fit infers in addition to the parameters.
void add_other_quantities(const decid::posterior::Posterior& found, std::vector<decid_parameter>& list) {
  using decid::posterior::Density;
  const auto add = [&](const char* name, const char* unit, int quantity) {
    describe(list.emplace_back(find_parameter(name, unit, found.mean(quantity))), found, quantity, no_mgh);
  };
  add("sensor_noise_deg", "deg", Density::sensor_noise);
  add("start_s", "s", Density::start);
  add("gain", "1", Density::gain);
}

decid_figures figures_of(const decid::RecordingResult& result, const decid::sim::Body& body, bool body_assumed) {
  const decid::Explanation& explanation = result.explanation;
  decid_figures figures{explanation.rms_residual_deg,
                        explanation.variance_accounted_for,
                        result.peak_to_peak_deg(),
                        explanation.response_ratio,
                        explanation.ood_score,
                        unknown,
                        unknown,
                        unknown,
                        body.mass_kg,
                        body.com_height_m,
                        body.inertia_kgm2,
                        body_assumed ? 1 : 0};
  if (const auto& tilt = result.trial.tilt) {
    figures.tilt_delay_s = tilt->delay_s;
    figures.tilt_correlation = tilt->correlation;
    figures.tilt_gain = tilt->gain;
  }
  return figures;
}

decid_sampling sampling_of(const decid::FitFigures& fit) {
  return {fit.posterior.chains(),
          fit.posterior.draws(),
          fit.posterior.agreed() ? 1 : 0,
          fit.answer == decid::FitFigures::Answer::network ? 1 : 0,
          fit.posterior.divergences(),
          fit.samples_noise_deg,
          fit.seconds};
}

std::vector<decid_compared_controller> controllers_of(const decid::FitFigures& fit, const std::string& own) {
  std::vector<decid_compared_controller> list;
  const auto add = [&](const std::string& name, const decid::posterior::ComparedModel& of, bool comparable) {
    list.push_back({name.c_str(), of.log_density, of.difference, of.standard_error, of.weight, comparable ? 1 : 0});
  };
  if (!fit.compared) return list;
  add(own, *fit.compared, fit.comparable);
  for (const decid::ControllerFit& other : fit.others) add(other.controller, other.compared, other.comparable);
  return list;
}

}  // namespace

namespace decid::c {

std::optional<sim::Body> make_body(double mass_kg, double height_m, const char* where) {
  if ((mass_kg == 0.0) != (height_m == 0.0))
    throw Error(Code::setting_missing, where,
                mass_kg == 0.0 ? "height_m is given without mass_kg" : "mass_kg is given without height_m",
                "give both, or neither for the protocol's body");
  if (mass_kg == 0.0) return {};
  return sim::body_of_participant({.mass_kg = mass_kg, .height_m = height_m});
}

}  // namespace decid::c

decid_result::decid_result(decid::RecordingResult of, const decid::Report& common)
    : result(std::move(of)),
      ranges(common.ranges_for(result)),
      warnings(to_c(result.warnings)),
      quantities(parameters_of(result, ranges, common.protocol.experiment.body)),
      figures(figures_of(result, common.protocol.experiment.body, common.body_assumed)),
      sampling{} {
  if (!result.fit) return;
  const decid::posterior::Posterior& found = result.fit->posterior;
  add_other_quantities(found, quantities);
  sampling = sampling_of(*result.fit);
  controllers = controllers_of(*result.fit, common.protocol.experiment.body_model->name);
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    quantities[q].rhat = found.rhat()[q];
    quantities[q].effective_draws = found.effective_draws()[q];
    draws.push_back(found.draws_for(found.quantity(q)));
  }
}

namespace {

template <class Options>
decid::RecordingResult brought(const decid_recording& recording, const decid::sim::Protocol& protocol,
                               const std::optional<decid::sim::Body>& body, const Options& asked, const char* where) {
  return decid::bring(recording.recording, decid::recording::ProtocolPlan(protocol), trial_options(asked, where), body);
}

std::unique_ptr<decid_result> identify(const decid_model& model, const decid_recording& recording,
                                       const decid_identify_options& asked) {
  constexpr const char* where = "decid_identify";
  const std::optional<decid::sim::Body> body = make_body(asked.mass_kg, asked.height_m, where);
  decid::Identifier identifier =
      body ? decid::Identifier(model.model, decid::for_body(model.model, model.name, body)) : *model.identifier;
  decid::RecordingResult result = brought(recording, model.model.protocol, body, asked, where);
  identifier.identify(std::span(&result, 1));
  return std::make_unique<decid_result>(std::move(result), make_report(identifier));
}

std::vector<decid::posterior::ParameterPrior> parameter_priors(const decid_fit_options& asked, const char* where) {
  std::vector<decid::posterior::ParameterPrior> priors;
  if (asked.parameter_prior_count > 0) given(asked.parameter_priors, where, "parameter_priors");
  for (std::size_t i = 0; i < asked.parameter_prior_count; ++i) {
    const decid_parameter_prior& of = asked.parameter_priors[i];
    const decid::posterior::PriorName name(&given(of.name, where, "parameter_priors.name"));
    const bool has_range = !std::isnan(of.low) || !std::isnan(of.high),
               has_normal = !std::isnan(of.mean) || !std::isnan(of.sd);
    // A range in SI units and a normal prior over m g h have two names, and are of one parameter. Any other second
    // entry of a parameter stays separate, and the fit refuses it.
    const auto other = std::ranges::find_if(priors, [&](const decid::posterior::ParameterPrior& one) {
      return has_range != has_normal && one.name == name.parameter && one.range.has_value() == has_normal &&
             one.normal.has_value() == has_range;
    });
    decid::posterior::ParameterPrior& prior = other != priors.end() ? *other : priors.emplace_back();
    prior.name = name.parameter;
    if (has_range) prior.range = {of.low, of.high};
    if (has_range) prior.over_mgh.range = name.over_mgh;
    if (has_normal) prior.normal = {of.mean, of.sd};
    if (has_normal) prior.over_mgh.normal = name.over_mgh;
  }
  return priors;
}

/// Removes priors of parameters that this controller does not have and another one of the fit has.
std::vector<decid::posterior::ParameterPrior> priors_for(const decid::sim::BodyModel& controller,
                                                         const std::vector<const decid::sim::BodyModel*>& all,
                                                         std::vector<decid::posterior::ParameterPrior> priors) {
  std::erase_if(priors, [&](const decid::posterior::ParameterPrior& prior) {
    return decid::is_of_another(prior.name, controller, all);
  });
  return priors;
}

std::unique_ptr<decid_result> fit(const decid_model& model, const decid_recording& recording,
                                  const decid_fit_options& asked) {
  constexpr const char* where = "decid_fit";
  decid::sim::Protocol protocol = asked.protocol != nullptr ? asked.protocol->protocol() : model.model.protocol;
  std::optional<decid::sim::Body> body = make_body(asked.mass_kg, asked.height_m, where);
  if (body) decid::sim::refuse_person(*body, protocol, where);
  // A protocol of one's own may describe it.
  if (!body && asked.protocol != nullptr && protocol.experiment.body != decid::sim::Body{})
    body = protocol.experiment.body;
  if (body) protocol.experiment.body = *body;
  decid::FitRequest request;
  request.priors.start_s = asked.prior_start_s;
  request.priors.gain = asked.prior_gain;
  request.priors.sensor_noise_deg = asked.prior_noise_deg;
  request.priors.moved_before = asked.moved_before != 0;
  const std::vector<const decid::sim::BodyModel*> controllers =
      decid::controllers_to_fit(text_or_empty(asked.controllers), protocol, decid::setting("controllers"));
  const std::vector<decid::posterior::ParameterPrior> priors = parameter_priors(asked, where);
  protocol.experiment.body_model = controllers.front();
  request.priors.parameters = priors_for(*controllers.front(), controllers, priors);
  for (const decid::sim::BodyModel* other : std::span(controllers).subspan(1))
    request.others.push_back({other, priors_for(*other, controllers, priors)});
  set_sampler(request.settings, asked.seed, asked.max_draws, where);
  decid::RecordingResult result = brought(recording, protocol, body, asked, where);
  decid::Fitter fitter(&model.model, protocol, body, request);
  bool stopped = false;
  fitter.fit(std::span(&result, 1), [&](std::size_t, const decid::posterior::Progress& progress) {
    if (asked.progress != nullptr) stopped = asked.progress(asked.user, progress.done, progress.stage) != 0;
    return !stopped;
  });
  if (stopped) throw Stopped{where};
  if (result.error) throw decid::Error(*result.error);
  return std::make_unique<decid_result>(std::move(result), fitter.report());
}

}  // namespace

void decid_identify_defaults(decid_identify_options* options, size_t size) {
  decid_identify_options defaults{};
  defaults.begin_s = unknown;
  set_defaults(options, size, defaults);
}
decid_status decid_identify(const decid_model* model, const decid_recording* recording,
                            const decid_identify_options* options, decid_result** result) {
  constexpr const char* where = "decid_identify";
  return made(result, where, [&] {
    return identify(given(model, where, "model"), given(recording, where, "recording"),
                    options_of(options, decid_identify_defaults, where));
  });
}

void decid_fit_defaults(decid_fit_options* options, size_t size) {
  const decid::FitRequest request;
  decid_fit_options defaults{};
  defaults.begin_s = unknown;
  defaults.prior_start_s = request.priors.start_s;
  defaults.prior_gain = request.priors.gain;
  defaults.prior_noise_deg = request.priors.sensor_noise_deg;
  defaults.max_draws = request.settings.max_draws;
  defaults.seed = request.settings.seed;
  set_defaults(options, size, defaults);
}
decid_status decid_fit(const decid_model* model, const decid_recording* recording, const decid_fit_options* options,
                       decid_result** result) {
  constexpr const char* where = "decid_fit";
  return made(result, where, [&] {
    return fit(given(model, where, "model"), given(recording, where, "recording"),
               options_of(options, decid_fit_defaults, where));
  });
}

void decid_result_free(decid_result* result) {
  delete result;
}
decid_trust decid_result_trust(const decid_result* result) {
  if (result == nullptr) return DECID_NOT_USABLE;
  return static_cast<decid_trust>(result->result.trust());
}
size_t decid_result_parameters(const decid_result* result) {
  return result == nullptr ? 0 : result->ranges.size();
}
size_t decid_result_quantities(const decid_result* result) {
  return result == nullptr ? 0 : result->quantities.size();
}
const decid_parameter* decid_result_parameter(const decid_result* result, size_t index) {
  return result == nullptr ? nullptr : at(result->quantities, index);
}
double decid_result_correlation(const decid_result* result, size_t a, size_t b) {
  if (result == nullptr || a >= result->quantities.size() || b >= result->quantities.size()) return unknown;
  const bool of_parameters = a < result->ranges.size() && b < result->ranges.size();
  const std::optional<decid::FitFigures>& fit = result->result.fit;
  if (fit && !(of_parameters && fit->answer == decid::FitFigures::Answer::network))
    return fit->posterior.correlation(fit->posterior.quantity(a), fit->posterior.quantity(b));
  const auto& distribution = result->result.estimate.distribution;
  return distribution ? distribution->correlation(static_cast<int>(a), static_cast<int>(b)) : unknown;
}
const decid_figures* decid_result_figures(const decid_result* result) {
  return result == nullptr ? nullptr : &result->figures;
}
size_t decid_result_warnings(const decid_result* result) {
  return result == nullptr ? 0 : result->warnings.size();
}
const decid_warning* decid_result_warning(const decid_result* result, size_t index) {
  return result == nullptr ? nullptr : at(result->warnings, index);
}

namespace {

const float* values_of(const std::vector<float>& values, size_t* samples) {
  if (samples != nullptr) *samples = values.size();
  return values.data();
}

}  // namespace

const float* decid_result_sway(const decid_result* result, size_t* samples) {
  if (result == nullptr) return values_of({}, samples);
  return values_of(result->result.trial.signals.find(decid::recording::com_sway)->rad, samples);
}
const float* decid_result_fitted(const decid_result* result, size_t* samples) {
  if (result == nullptr) return values_of({}, samples);
  return values_of(result->result.explanation.fitted_rad, samples);
}
const decid_sampling* decid_result_sampling(const decid_result* result) {
  return result == nullptr || !result->result.fit ? nullptr : &result->sampling;
}
const double* decid_result_draws(const decid_result* result, size_t quantity) {
  return result == nullptr || quantity >= result->draws.size() ? nullptr : result->draws[quantity].data();
}
size_t decid_result_controllers(const decid_result* result) {
  return result == nullptr ? 0 : result->controllers.size();
}
const decid_compared_controller* decid_result_controller(const decid_result* result, size_t index) {
  return result == nullptr ? nullptr : at(result->controllers, index);
}
