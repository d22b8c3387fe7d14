// Several controllers over the recordings of a call: in how many each predicts best, and the sum of its log predictive
// densities (posterior/sampling/leave_one_out.hpp).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace decid {
struct Report;

/// One controller among those of a call.
struct SummedController {
  std::string name;
  std::size_t best_in = 0;   ///< recordings of which no other controller has a larger density; of two alike the first
  double log_density = 0.0;  ///< sum of its log predictive densities, nats
  double difference = 0.0;   ///< to the controller with the largest sum: 0 or below
  double standard_error = 0.0;  ///< of the difference, of independent recordings; 0 for that controller
};

struct ControllerSums {
  std::size_t recordings = 0, not_usable = 0;  ///< with a comparison; those of them that are not usable
  std::vector<SummedController> controllers;   ///< the one that answers first
};

/// Sums the recordings with a comparison; empty for fewer than two. Standard errors add up as squares. The standard
/// error of two controllers in a recording where a third one is best is at most the sum of theirs to that one
/// (Minkowski), which counts. Recordings that are not usable count too: a controller that explains a recording badly
/// may be the reason.
std::optional<ControllerSums> sum_controllers(const Report& report);

}  // namespace decid
