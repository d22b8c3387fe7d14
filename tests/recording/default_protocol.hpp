// The default protocol's simulator and plan, of which all cases of a file share one, and its trials.
#pragma once

#include <cstdint>
#include <vector>

#include "recording/trial.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"

namespace decid::test {

inline const sim::Simulator& simulator() {
  static const sim::Simulator made(sim::default_protocol());
  return made;
}
inline const recording::ProtocolPlan& plan() {
  static const recording::ProtocolPlan made(simulator().protocol());
  return made;
}

/// Returns trial i of the prior in rad, without measurement noise: of the first body that stands after `change`.
template <class Change>
std::vector<double> trial_of_prior(std::uint64_t seed, std::uint64_t i, const Change& change) {
  const sim::ParameterTable& table = simulator().protocol().parameters();
  std::vector<double> values(static_cast<std::size_t>(simulator().samples()));
  for (std::uint64_t attempt = 1000 * i;; ++attempt) {
    const Random random(seed, sim::streams::base_parameters, attempt);
    sim::Parameters parameters(table.size());
    for (std::size_t p = 0; p < table.size(); ++p) parameters[p] = random.uniform(p, table[p].low, table[p].high);
    change(parameters);
    if (simulator().run(parameters, Random(seed, sim::streams::vestibular_noise, attempt), values).valid) return values;
  }
}

}  // namespace decid::test
