// Iterative fits of recordings: see fit_recordings.hpp.
#include "identify/fit/fit_recordings.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/error.hpp"
#include "base/text.hpp"

namespace decid {
namespace {

/// What the network's answer is taken for: known beforehand to this part of the ranges. On trials of a seed that no
/// figure is quoted for 0.08 erred less than 0.15, and both less than nothing known.
constexpr double network_spread = 0.08;
/// Parameters this near to an edge, as part of the range, are told.
constexpr double edge = 0.02;

const char* name_of(StartKind start) {
  if (start == StartKind::network) return "network";
  return start == StartKind::middle ? "middle" : "random";
}

void warn(Fitted& fitted) {
  std::vector<std::string>& warnings = fitted.identification.warnings;
  const std::vector<double> unit = fit::to_unit(fitted.result.parameters);
  for (std::size_t p = 0; p < sim::parameter_count; ++p) {
    const sim::ParameterInfo& info = sim::parameter_info[p];
    if (unit[p] < edge || unit[p] > 1 - edge)
      warnings.push_back(format("%s lies at the edge of its range (%g to %g%s), which the fit does not leave",
                                info.name, info.low, info.high, sim::unit_after(info).c_str()));
  }
}

void fit_one(Model* model, const sim::Simulator& simulator, const FitRequest& request, Fitted& fitted) {
  Identification& id = fitted.identification;
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<fit::Start> starts =
      fit_starts(request, model == nullptr ? sim::middle_parameters() : ask_network(*model, id.sway_rad));
  fitted.result = fit::fit(simulator, id.sway_rad, starts, request.settings);
  if (!fitted.result.stands) {
    id.error = Error(id.file, "every trial that the fit simulated fell", "try --start middle, or more --simulations");
    return;
  }
  fitted.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  fitted.start = fitted.result.start == 0 ? name_of(request.start) : "random";
  id.parameters = fitted.result.parameters;
  explain(simulator, id);
  warn_unless_following(id);
  warn(fitted);
}

}  // namespace

sim::Parameters ask_network(Model& model, std::span<const float> sway_rad) {
  const std::vector<float> output = predict(model, 1, 1, sways_in_memory([&](int) { return sway_rad; }));
  return model.targets.unscale(output);
}

std::vector<fit::Start> fit_starts(const FitRequest& request, const sim::Parameters& network) {
  std::vector<fit::Start> starts;
  if (request.start == StartKind::network) starts.push_back({network, network_spread, network_spread});
  if (request.start == StartKind::middle) starts.push_back(fit::middle_start());
  while (starts.size() < static_cast<std::size_t>(request.starts))
    starts.push_back(fit::random_start(request.settings.seed, starts.size()));
  return starts;
}

std::vector<Fitted> fit_recordings(Model* model, const sim::Protocol& protocol,
                                   const std::vector<std::filesystem::path>& files, const ReadOptions& options,
                                   const FitRequest& request, const FitDone& done) {
  const bool ask = request.start == StartKind::network;
  if (ask && (model == nullptr || !sim::same_experiment(model->protocol, protocol)))
    throw Error("--start network", "the model was trained on another protocol than '" + protocol.name + "'",
                "give a --model for this protocol, or --start middle");
  fit::check_budget(request.settings, static_cast<std::size_t>(request.starts));
  const sim::Simulator simulator(protocol);
  std::vector<Fitted> all;
  for (Identification& id : read_recordings(simulator, files, options)) {
    Fitted& fitted = all.emplace_back();
    fitted.identification = std::move(id);
    if (!fitted.identification.error) fit_one(ask ? model : nullptr, simulator, request, fitted);
    if (!done(all.size())) break;
  }
  return all;
}

}  // namespace decid
