// Iterative fits of recordings, from files to parameters, and where their searches start.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "identify/fit/fit.hpp"
#include "identify/model.hpp"
#include "identify/recordings.hpp"

namespace decid {

enum class StartKind { network, middle, random };

struct FitRequest {
  StartKind start = StartKind::network;
  int starts = 2;  ///< searches: the first from `start`, the others from random places
  fit::Settings settings;
};

/// What the network says of a trial of its protocol.
sim::Parameters ask_network(Model& model, std::span<const float> sway_rad);

/// `network`: what the network says of the recording; needed for StartKind::network only. Its search begins closer.
std::vector<fit::Start> fit_starts(const FitRequest& request, const sim::Parameters& network);

struct Fitted {
  Identification identification;  ///< its parameters are result.parameters; no image. Nothing below if it has an error
  std::string start;              ///< whose search found them: "network", "middle", "random"
  fit::Result result;
  double seconds = 0.0;
};

/// Called with the number of recordings done; returns false to stop.
using FitDone = std::function<bool(std::size_t done)>;

/// Reads and fits each recording in `protocol`; one that cannot be used has an `error` and costs the others nothing.
/// model: for the network's start; may be null for the others. Throws Error if the model's experiment is not the
/// protocol's, and for too small a budget.
std::vector<Fitted> fit_recordings(Model* model, const sim::Protocol& protocol,
                                   const std::vector<std::filesystem::path>& files, const ReadOptions& options,
                                   const FitRequest& request, const FitDone& done);

}  // namespace decid
