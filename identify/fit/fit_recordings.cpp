// Iterative fits of recordings: see fit_recordings.hpp.
#include "identify/fit/fit_recordings.hpp"

#include <chrono>

#include "base/error.hpp"
#include "base/text.hpp"

namespace decid {
namespace {

/// Deviation of the prior about the network's answer, as part of the ranges. On trials of a seed that no figure is
/// quoted for, 0.08 erred less than 0.15, and both less than no prior.
constexpr double network_spread = 0.08;
/// Parameters this near to an edge, as part of the range, get a warning.
constexpr double edge = 0.02;

const char* name_of(StartKind start) {
  if (start == StartKind::network) return "network";
  return start == StartKind::middle ? "middle" : "random";
}

void warn_of_edges(const sim::ParameterTable& table, Identification& id) {
  const std::vector<double> unit = table.to_unit(id.estimate.parameters);
  for (std::size_t p = 0; p < table.size(); ++p) {
    const sim::ParameterInfo& info = table[p];
    if (unit[p] < edge || unit[p] > 1 - edge)
      id.explanation.warnings.push_back(
          format("%s lies at the edge of its range (%g to %g%s), which the fit does not leave", info.name.c_str(),
                 info.low, info.high, info.unit_after().c_str()));
  }
}

FitFigures fit_one(Identifier* network, const Explainer& explainer, const FitRequest& request, Identification& id) {
  FitFigures figures;
  const auto begin = std::chrono::steady_clock::now();
  const sim::ParameterTable& table = explainer.simulator().protocol().parameters();
  const std::vector<fit::Start> starts =
      fit_starts(request, table, network == nullptr ? table.middle() : ask_network(*network, id.estimate.trial));
  figures.result = fit::fit(explainer.simulator(), id.estimate.trial.sway_rad(), starts, request.settings);
  if (!figures.result.stands) {
    id.error = Error(id.file, "every trial that the fit simulated fell", "try --start middle, or more --simulations");
    return figures;
  }
  figures.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  figures.start = figures.result.start == 0 ? name_of(request.start) : "random";
  id.estimate.parameters = figures.result.parameters;
  id.explanation = explainer.explain({id.estimate.parameters, id.estimate.trial});
  warn_unless_following(id.explanation);
  warn_of_edges(table, id);
  return figures;
}

}  // namespace

sim::Parameters ask_network(Identifier& network, const dataset::Trial& trial) {
  return network.estimate({trial}).front().parameters;
}

std::vector<fit::Start> fit_starts(const FitRequest& request, const sim::ParameterTable& table,
                                   const sim::Parameters& network) {
  std::vector<fit::Start> starts;
  if (request.start == StartKind::network) starts.push_back({network, network_spread, network_spread});
  if (request.start == StartKind::middle) starts.push_back(fit::middle_start(table));
  while (starts.size() < static_cast<std::size_t>(request.starts))
    starts.push_back(fit::random_start(table, request.settings.seed, starts.size()));
  return starts;
}

FittedRecordings fit_recordings(const Model* model, const sim::Protocol& protocol,
                                const std::vector<std::filesystem::path>& files, const ReadOptions& options,
                                const FitRequest& request, const FitDone& done) {
  const bool ask = request.start == StartKind::network;
  if (ask && (model == nullptr || model->protocol.experiment != protocol.experiment))
    throw Error("--start network", "the model was trained on another protocol than '" + protocol.name + "'",
                "give a --model for this protocol, or --start middle");
  fit::check_budget(request.settings, static_cast<std::size_t>(request.starts));
  const Explainer explainer{sim::Simulator(protocol)};
  std::optional<Identifier> network;
  if (ask) network.emplace(*model);
  FittedRecordings all;
  all.identified.protocol = protocol;
  for (Identification& read : read_recordings(protocol, files, options)) {
    Identification& id = all.identified.recordings.emplace_back(std::move(read));
    all.fits.push_back(id.error ? FitFigures{} : fit_one(ask ? &*network : nullptr, explainer, request, id));
    if (!done(all.fits.size())) break;
  }
  return all;
}

}  // namespace decid
