// A simulated trial with its sway.
#pragma once

#include <vector>

#include "base/math/random.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"

namespace decid::test {

inline const Random some_noise(1, sim::streams::vestibular_noise, 0);

struct Run {
  sim::Outcome outcome;
  std::vector<double> sway;
};

inline Run simulate(const sim::Simulator& simulator, const sim::Parameters& parameters,
                    const Random& noise = some_noise) {
  Run trial{{}, std::vector<double>(static_cast<std::size_t>(simulator.samples()))};
  trial.outcome = simulator.run(parameters, noise, trial.sway);
  return trial;
}

}  // namespace decid::test
