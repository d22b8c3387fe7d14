// decid fit --frf: a published frequency response in, the posterior of its controllers out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/files/json_object.hpp"
#include "identify/result.hpp"
#include "posterior/frf/fit.hpp"

namespace decid::tools {

/// A fit of one table.
struct FrfFit {
  std::string table, output, draws, page;  ///< files; the last three may be empty
  struct Controller {
    sim::Protocol protocol;
    frf::Priors priors;
  };
  std::vector<Controller> controllers;  ///< several: they are compared
  std::optional<sim::Parameters> truth;
  frf::SmcSettings particles;
  bool log_ratio = false;  ///< least squares instead of the posterior
  bool json = false;
  Json options;  ///< as they were given
  Call call = {};
  bool body_assumed = false;  ///< the protocol's own body
};

/// Fits, writes the files and prints. Throws Error for a table or protocol that cannot be used.
void run_frf_fit(const FrfFit& asked);

}  // namespace decid::tools
