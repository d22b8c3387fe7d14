// Several controllers of one recording: which fits can be compared, and which predicts far better. Several over the
// recordings of a call: in how many each predicts best, and the sum of its log predictive densities
// (posterior/sampling/leave_one_out.hpp).
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/warning.hpp"
#include "posterior/sampling/leave_one_out.hpp"

namespace decid {
struct FitFigures;
struct Report;
namespace sim {
struct BodyModel;
struct Protocol;
}  // namespace sim

/// Returns the controllers to fit, the one that answers first: those of `names`, separated by commas, or the protocol's
/// for an empty text. Throws Error at `where` for a name that no controller has, for one that is given twice, and if
/// the protocol's controller is not among the names, unless it is `dec` and the protocol does not name it.
std::vector<const sim::BodyModel*> controllers_to_fit(const std::string& names, const sim::Protocol& protocol,
                                                      const std::string& where);

/// Returns true if another one of the controllers has this parameter, and `controller` has not: a prior of it does not
/// act on `controller`.
bool is_of_another(const std::string& parameter, const sim::BodyModel& controller,
                   std::span<const sim::BodyModel* const> all);

/// Returns true if the chains of a fit agree well enough to compare its predictions: the largest R-hat of a parameter
/// is at most 1.2, and no warning says `divergences`.
bool chains_allow_comparison(double max_rhat, const Warnings& warnings);

/// Returns the caution `other_controller` that names the best of the controllers that predict far better than the
/// first: by more than 4 nats and 4 standard errors, over all blocks, and also over the blocks that are reliable in
/// both fits (LeaveOneOut::max_reliable_shape). Empty if there is none, and if the first is not comparable. left_out:
/// of each controller, of the same blocks; comparable: of each; other fits are ignored; names: the one that answers
/// first.
std::optional<Warning> better_controller_warning(std::span<const posterior::LeaveOneOut> left_out,
                                                 const std::vector<bool>& comparable,
                                                 const std::vector<std::string>& names);

/// Compares the controllers of a recording, whose fits are in `figures`: the protocol's, `own`, and its others. Returns
/// better_controller_warning(). left_out: of each of them, the protocol's first. warnings: those of the protocol's.
std::optional<Warning> compare_controllers(std::span<const posterior::LeaveOneOut> left_out, const std::string& own,
                                           const Warnings& warnings, FitFigures& figures);

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
  std::size_t not_comparable = 0;              ///< those with a fit that is not comparable; they count
  std::vector<SummedController> controllers;   ///< the one that answers first
};

/// Sums the recordings with a comparison; empty for fewer than two. Standard errors add up as squares. The standard
/// error of two controllers in a recording where a third one is best is at most the sum of theirs to that one
/// (Minkowski), which counts. Recordings that are not usable count too: a controller that explains a recording badly
/// may be the reason.
std::optional<ControllerSums> sum_controllers(const Report& report);

}  // namespace decid
