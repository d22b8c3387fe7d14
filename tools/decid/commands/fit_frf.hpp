// decid fit --frf: a published frequency response in, the posterior of its controller out.
#pragma once

#include <optional>
#include <string>

#include "base/files/json_object.hpp"
#include "posterior/frf/fit.hpp"

namespace decid::tools {

/// A fit of one table.
struct FrfFit {
  std::string table, output, draws;  ///< files; the last two may be empty
  sim::Protocol protocol;
  std::optional<sim::Parameters> truth;
  frf::Priors priors;
  frf::SmcSettings particles;
  bool json = false;
  Json options;               ///< as they were given
  bool body_assumed = false;  ///< the protocol's own body
};

/// Fits, writes the files and prints. Throws Error for a table or protocol that cannot be used.
void run_frf_fit(const FrfFit& asked);

}  // namespace decid::tools
