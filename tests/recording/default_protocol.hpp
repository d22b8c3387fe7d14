// The default protocol's simulator and plan, of which all cases of a file share one.
#pragma once

#include "recording/trial.hpp"
#include "sim/simulate.hpp"

namespace decid::test {

inline const sim::Simulator& simulator() {
  static const sim::Simulator made(sim::default_protocol());
  return made;
}
inline const recording::ProtocolPlan& plan() {
  static const recording::ProtocolPlan made(simulator().protocol());
  return made;
}

}  // namespace decid::test
