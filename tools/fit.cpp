// Iterative fits of recordings: see fit.hpp.
#include "tools/fit.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "tools/identify.hpp"
#include "tools/text.hpp"

namespace decid::tools {
namespace {

using Json = nlohmann::ordered_json;

/// First standard deviation of a search from the network's answer: about its error, as part of the ranges.
constexpr double network_spread = 0.15;
/// Parameters this near to an edge, as part of the range, are told.
constexpr double edge = 0.02;

const char* name_of(StartKind start) {
  if (start == StartKind::network) return "network";
  return start == StartKind::middle ? "middle" : "random";
}

/// The noise-free trial of the fitted parameters beside the recording, means removed.
void compare_with_recording(const sim::Simulator& simulator, Identification& id) {
  sim::Parameters noise_free = id.parameters;
  noise_free[sim::Nv] = 0;
  std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
  if (!simulator.run(noise_free, Random(0, Stream::vestibular_noise, 0), sway).valid) {
    id.rms_residual_deg = id.variance_accounted_for = std::nan("");
    id.warnings.push_back("the fitted controller does not stand without its noise: there is no fit to quote");
    return;
  }
  id.fitted_rad.assign(sway.begin(), sway.end());
  double mean = 0, difference_mean = 0, variance = 0, residual = 0;
  const auto count = static_cast<double>(sway.size());
  for (std::size_t k = 0; k < sway.size(); ++k) {
    mean += static_cast<double>(id.sway_rad[k]) / count;
    difference_mean += (static_cast<double>(id.sway_rad[k]) - sway[k]) / count;
  }
  for (std::size_t k = 0; k < sway.size(); ++k) {
    const double centred = static_cast<double>(id.sway_rad[k]) - mean;
    const double difference = static_cast<double>(id.sway_rad[k]) - sway[k] - difference_mean;
    variance += centred * centred;
    residual += difference * difference;
  }
  id.rms_residual_deg = std::sqrt(residual / count) / sim::rad_per_deg;
  id.variance_accounted_for = 1 - residual / variance;
}

void warn(Fitted& fitted) {
  std::vector<std::string>& warnings = fitted.identification.warnings;
  if (!fitted.result.stands) {
    warnings.push_back("no simulated trial stood: the figures mean nothing; try --start middle, or more --simulations");
    return;
  }
  const std::vector<double> unit = fit::to_unit(fitted.result.parameters);
  for (std::size_t p = 0; p < sim::parameter_count; ++p) {
    const sim::ParameterInfo& info = sim::parameter_info[p];
    if (unit[p] < edge || unit[p] > 1 - edge)
      warnings.push_back(format("%s lies at the edge of its range (%g to %g %s), which the fit does not leave",
                                info.name, info.low, info.high, info.unit));
  }
}

sim::Parameters ask_network(Model& model, const Identification& id) {
  const std::vector<float> output =
      predict(model, 1, 1, sways_in_memory([&](int) { return std::span<const float>(id.sway_rad); }));
  return model.targets.unscale(output);
}

}  // namespace

std::vector<fit::Start> fit_starts(const FitRequest& request, const sim::Parameters& network) {
  std::vector<fit::Start> starts;
  if (request.start == StartKind::network) starts.push_back({network, network_spread});
  if (request.start == StartKind::middle) starts.push_back(fit::middle_start());
  while (starts.size() < static_cast<std::size_t>(request.starts))
    starts.push_back(fit::random_start(request.settings.seed, starts.size()));
  return starts;
}

std::vector<Fitted> fit_recordings(Model* model, const sim::Protocol& protocol,
                                   const std::vector<std::filesystem::path>& files,
                                   const dataset::RecordingOptions& options, const FitRequest& request) {
  const bool ask = request.start == StartKind::network;
  if (ask && (model == nullptr || !sim::same_experiment(model->protocol, protocol)))
    throw Error("--start network", "the model was trained on another protocol than '" + protocol.name + "'",
                "give a --model for this protocol, or --start middle");
  std::vector<Fitted> all(files.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    Identification& id = all[i].identification;
    dataset::Recording recording = dataset::read_recording(files[i], options);
    id.sway_rad = dataset::fit_to_protocol(recording, protocol);
    id.file = recording.file;
    id.column = recording.column;
    id.warnings = std::move(recording.warnings);
    id.protocol = protocol;
    const auto [low, high] = std::ranges::minmax(id.sway_rad);
    id.peak_to_peak_deg = static_cast<double>(high - low) / sim::rad_per_deg;
  }
  const sim::Simulator simulator(protocol);
  for (Fitted& fitted : all) {
    Identification& id = fitted.identification;
    const auto begin = std::chrono::steady_clock::now();
    const std::vector<fit::Start> starts =
        fit_starts(request, ask ? ask_network(*model, id) : sim::middle_parameters());
    fitted.result = fit::fit(simulator, id.sway_rad, starts, request.settings);
    fitted.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    fitted.start = fitted.result.start == 0 ? name_of(request.start) : "random";
    id.parameters = fitted.result.parameters;
    compare_with_recording(simulator, id);
    warn(fitted);
  }
  return all;
}

std::string fits_json(const std::string& model, const std::vector<Fitted>& all) {
  std::vector<Identification> identifications;
  for (const Fitted& fitted : all) identifications.push_back(fitted.identification);
  Json json = Json::parse(identifications_json(model, identifications));
  for (std::size_t i = 0; i < all.size(); ++i) {
    const fit::Result& result = all[i].result;
    Json& recording = json["recordings"][i];
    for (std::size_t p = 0; p < sim::parameter_count; ++p) {
      recording["parameters"][p]["standard_error"] = result.standard_error[p];
      recording["parameters"][p]["likeliest"] = result.likeliest[p];
    }
    recording["fit"]["cost"] = result.cost;
    recording["fit"]["sensor_noise_deg"] = result.sensor_noise_deg;
    recording["fit"]["start"] = all[i].start;
    recording["fit"]["simulations"] = result.simulations;
    recording["fit"]["effective_samples"] = result.effective_samples;
    recording["fit"]["seconds"] = all[i].seconds;
  }
  return json.dump(2) + "\n";
}

std::string fits_text(const std::vector<Fitted>& all) {
  std::string text;
  for (const Fitted& fitted : all) {
    const Identification& id = fitted.identification;
    const fit::Result& result = fitted.result;
    text += format("%s (%s): peak to peak %.3f degrees", id.file.c_str(), id.column.c_str(), id.peak_to_peak_deg);
    if (std::isfinite(id.rms_residual_deg))
      text += format(", rms residual %.3f degrees, variance accounted for %.1f%%", id.rms_residual_deg,
                     100 * id.variance_accounted_for);
    text += format("\n  cost %.1f after %lld simulations in %.1f s, found from start %s; sensor noise %.2g degrees\n",
                   result.cost, result.simulations, fitted.seconds, fitted.start.c_str(), result.sensor_noise_deg);
    text +=
        format("  %-8s %12s %10s %-10s %10s %12s  %s\n", "", "fitted", "+-", "unit", "/ (m g h)", "likeliest", "range");
    for (std::size_t p = 0; p < sim::parameter_count; ++p) {
      const sim::ParameterInfo& info = sim::parameter_info[p];
      text += format("  %-8s %12.5g %10.3g %-10s ", info.name, id.parameters[p], result.standard_error[p], info.unit);
      text += info.per_mgh ? format("%10.4f", id.parameters[p] / id.protocol.body.mgh()) : std::string(10, ' ');
      text += format(" %12.5g  %g to %g\n", result.likeliest[p], info.low, info.high);
    }
    for (const std::string& warning : id.warnings) text += "  warning: " + warning + "\n";
  }
  return text;
}

}  // namespace decid::tools
