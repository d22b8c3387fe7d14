// Computations whose bits are known (docs/develop/determinism.md): does this machine, or do several together, compute
// them?
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/communicator.hpp"

namespace decid {

struct SelfCheck {
  const char *name, *expected;  ///< SHA-256
  /// Returns the SHA-256 that this machine computes. Null: a single process.
  std::function<std::string(Communicator* group)> compute;
  bool is_shared;  ///< several processes can compute it together
};

/// Returns the checks, each of a few seconds: training steps, a training on new trials in every epoch, simulated
/// trials.
std::vector<SelfCheck> self_checks();

}  // namespace decid
