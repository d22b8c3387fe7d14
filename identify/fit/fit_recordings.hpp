// Iterative fits of recordings, from files to parameters, and where their searches start.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "identify/fit/fit.hpp"
#include "identify/recordings.hpp"

namespace decid {

enum class StartKind { network, middle, random };

struct FitRequest {
  StartKind start = StartKind::network;
  int starts = 2;  ///< searches: the first from `start`, the others from random places
  fit::Settings settings;
};

/// The network's answer for a trial of its protocol.
sim::Parameters ask_network(Identifier& network, const dataset::Trial& trial);

/// `network`: its answer for the recording, needed for StartKind::network only. Its search begins closer.
std::vector<fit::Start> fit_starts(const FitRequest& request, const sim::ParameterTable& table,
                                   const sim::Parameters& network);

/// What a fit found besides the parameters and how well they explain the recording.
struct FitFigures {
  std::string start;  ///< the start whose search found them: "network", "middle", "random"
  fit::Result result;
  double seconds = 0.0;
};

/// The recordings of one call; their estimates are the fits', without images. fits: in their order; that of a
/// recording with an error means nothing.
struct FittedRecordings {
  Identifications identified;
  std::vector<FitFigures> fits;
};

/// Called with the number of recordings done; returns false to stop.
using FitDone = std::function<bool(std::size_t done)>;

/// Reads and fits each recording in `protocol`; one that cannot be used has an `error` and does not stop the others.
/// model: for the network's start; may be null for the others. Throws Error if the model's experiment is not the
/// protocol's, and for too small a budget.
FittedRecordings fit_recordings(const Model* model, const sim::Protocol& protocol,
                                const std::vector<std::filesystem::path>& files, const ReadOptions& options,
                                const FitRequest& request, const FitDone& done);

}  // namespace decid
