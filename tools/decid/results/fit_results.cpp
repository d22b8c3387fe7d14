// Posteriors as JSON, text and arrays: see fit_results.hpp.
#include "tools/decid/results/fit_results.hpp"

#include <cmath>
#include <deque>

#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "dataset/npz/arrays.hpp"
#include "tools/decid/results/posterior_results.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/fit_page.hpp"
#include "tools/report/parameters_json.hpp"

namespace decid::tools {
namespace {

using posterior::Density;
using posterior::Posterior;

Json diagnostics_json(const Posterior& found, const sim::ParameterTable& table) {
  Json json = common_diagnostics(found, table.names(), {"sensor_noise_deg", "start_s", "gain"});
  json["divergences"] = found.divergences();
  json["energy_fraction"] = number_or_null(found.energy_fraction());
  json["restarts"] = found.restarts();
  json["gradients"] = found.leapfrog_steps();
  return json;
}

Json check_json(const PredictiveCheck& check) {
  Json figures = Json::array();
  for (const CheckedFigure& figure : check.figures)
    figures.push_back({{"name", figure.name},
                       {"unit", figure.in_degrees ? "deg" : "1"},
                       {"recorded", number_or_null(figure.recorded)},
                       {"simulated", number_or_null(figure.middle)},
                       {"simulated_interval90", {number_or_null(figure.low), number_or_null(figure.high)}},
                       {"p", figure.p}});
  return {{"trials", PredictiveCheck::trials}, {"standing", check.standing}, {"figures", std::move(figures)}};
}

Json left_out_json(const FitFigures& fitted) {
  const posterior::LeaveOneOut& left_out = fitted.inferred.left_out;
  return {{"value", left_out.log_density},
          {"standard_error", left_out.standard_error},
          {"effective_parameters", left_out.effective_parameters},
          {"blocks", fitted.inferred.sway_rad.low.size()},
          {"block_s", fitted.block_s},
          {"max_shape", left_out.max_shape},
          {"unreliable_blocks", left_out.unreliable}};
}

/// The p-values in one line.
std::string check_text(const PredictiveCheck& check) {
  if (check.figures.empty()) return {};
  std::string text;
  for (const CheckedFigure& figure : check.figures)
    text += format("%s%s %.2g", text.empty() ? "" : ", ", figure.name.c_str(), figure.p);
  return "  simulated anew, two-sided p: " + text + "\n";
}

/// What is known beforehand of each parameter.
void add_priors(Json& parameters, const posterior::Priors& priors, const sim::ParameterTable& table) {
  for (std::size_t p = 0; p < table.size(); ++p) parameters[p]["range"] = {table[p].low, table[p].high};
  for (const posterior::ParameterPrior& prior : priors.parameters) {
    if (!prior.normal) continue;
    for (Json& parameter : parameters)
      if (parameter["name"] == prior.name)
        parameter["prior"] = {{"mean", prior.normal->mean}, {"sd", prior.normal->sd}};
  }
}

void add_posterior(Json& recording, const FitFigures& fitted, const sim::Protocol& protocol,
                   const posterior::Priors& priors, const sim::ParameterTable& table) {
  const Posterior& found = fitted.posterior;
  add_priors(recording["parameters"], priors, table);
  if (fitted.answer == FitFigures::Answer::posterior) {  // else values, deviations and intervals are the network's
    for (std::size_t p = 0; p < table.size(); ++p)
      add_found(recording["parameters"][p], found, p, table[p], protocol.experiment.body.mgh());
    recording["correlations"] = correlations_json(found, table.size());
  }
  recording["sensor_noise_deg"] = quantity_json(found, Density::sensor_noise);
  recording["sensor_noise_deg"]["of_samples"] = fitted.samples_noise_deg;
  // Chains hold these two while they draw: no interval.
  recording["slow_noise_deg"] = {{"value", found.mean(Density::slow_noise)},
                                 {"memory_s", found.mean(Density::slow_memory)}};
  recording["start_s"] = quantity_json(found, Density::start);
  recording["gain"] = quantity_json(found, Density::gain);
  recording["diagnostics"] = diagnostics_json(found, table);
  recording["predictive_check"] = check_json(fitted.check);
  recording["log_predictive_density"] = left_out_json(fitted);
  recording["fit"]["answer"] = name(fitted.answer);
}

std::string text_of(const Identification& id, const FitFigures& fitted, const sim::Protocol& protocol,
                    const sim::ParameterTable& table) {
  const Posterior& found = fitted.posterior;
  std::string text = headline(id);
  const bool networks = id.estimate.distribution.has_value();
  text += table_heading(fitted.answer == FitFigures::Answer::network ? "network" : "mean",
                        networks ? "90 % interval" : "90 % of the draws", id.truth.has_value());
  for (std::size_t p = 0; p < table.size(); ++p) {
    const double value = id.estimate.parameters[p], mgh = protocol.experiment.body.mgh();
    text += networks ? parameter_line(*id.estimate.distribution, p, table[p], value, mgh, id.truth)
                     : parameter_line(found, p, table[p], value, mgh, id.truth);
  }
  const auto line = [&](const char* what, int quantity, const char* unit) {
    if (found.deviation(quantity) > 0.0)
      text += format("  %s %.3g +- %.2g%s\n", what, found.mean(quantity), found.deviation(quantity), unit);
  };
  line("sensor noise", Density::sensor_noise, " degrees");
  text += format("  slow noise %.3g degrees, which forgets within %.2g s\n", found.mean(Density::slow_noise),
                 found.mean(Density::slow_memory));
  line("the recording starts", Density::start, " s after the protocol");
  line("recorded over true sway", Density::gain, "");
  const auto worst = std::ranges::max_element(found.rhat());
  const auto fewest = std::ranges::min_element(found.effective_draws());
  text += format("  %d chains, %d draws worth %.0f and more, R-hat %.3f and less, %d divergences; %.1f s\n",
                 found.chains(), found.draws(), *fewest, *worst, found.divergences(), fitted.seconds);
  return text + check_text(fitted.check) + sway_text(id) + warnings_text(id.warnings());
}

Json draws_of(const Posterior& found) {
  const auto states = found.states();
  const auto column = [&](auto&& value_of) {
    std::vector<double> values;
    for (std::size_t draw = 0; draw < states.size(); ++draw) values.push_back(value_of(draw));
    return values;
  };
  std::vector<double> parameters;
  for (const posterior::State& state : states)
    parameters.insert(parameters.end(), state.parameters.begin(), state.parameters.end());
  return {{"parameters", parameters},
          {"sensor_noise_deg", column([&](std::size_t draw) { return states[draw].sensor_noise_deg; })},
          {"slow_noise_deg", column([&](std::size_t draw) { return states[draw].slow_noise_deg; })},
          {"start_s", column([&](std::size_t draw) { return states[draw].start_s; })},
          {"gain", column([&](std::size_t draw) { return states[draw].gain; })},
          {"chain", column([&](std::size_t draw) {
             const std::size_t chain = draw / static_cast<std::size_t>(found.draws_per_chain());
             return static_cast<double>(chain);
           })}};
}

}  // namespace

Json fit_result(const FittedRecordings& all, std::size_t number, const posterior::Priors& priors) {
  const Identification& id = all.identified.recordings.at(number);
  const FitFigures& fitted = all.fits.at(number);
  const sim::Protocol& protocol = all.identified.protocol;
  Json result{{"recording", recording_json(id, protocol)}};
  if (id.error) {
    result["text"] = id.file + ": not fitted\n";
  } else {
    const sim::ParameterTable table = posterior::ranges_of(priors, protocol.ranges());
    add_posterior(result["recording"], fitted, protocol, priors, table);
    result["text"] = text_of(id, fitted, protocol, table);
    result["page"] = fit_page_recording(id, fitted, all.identified, table);
    result["draws"] = draws_of(fitted.posterior);
  }
  // As it comes back from a journal.
  return Json::parse(result.dump(-1, ' ', false, Json::error_handler_t::replace));
}

void write_draws(const std::filesystem::path& path, std::span<const Json> results) {
  std::deque<std::vector<double>> values;
  std::vector<dataset::NamedArray> arrays;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const auto found = results[i].find("draws");
    if (found == results[i].end()) continue;
    const std::string prefix = results.size() > 1 ? std::to_string(i + 1) + "/" : "";
    const std::size_t draws = found->at("chain").size();
    for (const auto& [name, array] : found->items()) {
      const std::vector<double>& column = values.emplace_back(array.get<std::vector<double>>());
      std::vector<std::size_t> shape{draws};
      if (name == "parameters") shape.push_back(column.size() / draws);
      arrays.push_back({prefix + name, std::move(shape), column});
    }
  }
  dataset::write_arrays(path, arrays);
}

}  // namespace decid::tools
