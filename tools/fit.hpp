// Iterative fits of recordings: what `decid fit` does, from files to parameters, and the starts that `decid compare`
// shares with it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/recording.hpp"
#include "fit/fit.hpp"
#include "tools/identification.hpp"
#include "tools/model.hpp"

namespace decid::tools {

enum class StartKind { network, middle, random };

struct FitRequest {
  StartKind start = StartKind::network;
  int starts = 2;  ///< searches: the first from `start`, the others from random places
  fit::Settings settings;
};

/// `network`: what the network says of the recording; needed for StartKind::network only. Its search begins closer.
std::vector<fit::Start> fit_starts(const FitRequest& request, const sim::Parameters& network);

struct Fitted {
  Identification identification;  ///< its parameters are result.parameters; no image
  std::string start;              ///< whose search found them: "network", "middle", "random"
  fit::Result result;
  double seconds = 0.0;
};

/// Reads and fits each recording in `protocol`. model: for the network's start; may be null for the others. Throws
/// Error for the first recording that cannot be used, and if the model's experiment is not the protocol's.
std::vector<Fitted> fit_recordings(Model* model, const sim::Protocol& protocol,
                                   const std::vector<std::filesystem::path>& files,
                                   const dataset::RecordingOptions& options, const FitRequest& request);

/// What identify prints, and for each recording the fit's own figures: standard errors, cost, simulations, seconds.
std::string fits_json(const std::string& model, const std::vector<Fitted>& all);
std::string fits_text(const std::vector<Fitted>& all);

}  // namespace decid::tools
