// A short experiment with a known trial, for tests of the posterior: 20 s of sines, 8 s of which repeat.
#pragma once

#include <cmath>
#include <vector>

#include "base/math/random.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/sim/sines.hpp"

namespace decid::test {

inline sim::Protocol sines_protocol() {
  return sines(0.1, 0.3, 20.0, 1, 20.0);  // the golden draws' trial: its noise repeats with it
}

/// The middle of every range but for these.
inline sim::Parameters some_parameters() {
  sim::Parameters parameters = sim::single_pendulum().parameters.middle();
  parameters[sim::Nv] = 0.3;
  parameters[sim::Theta] = 0.002;
  return parameters;
}

/// Its sway with that much sensor noise.
inline std::vector<float> recorded(const sim::Protocol& protocol, const sim::Parameters& parameters, double noise_deg,
                                   std::uint64_t item) {
  const sim::Simulator simulator(protocol);
  std::vector<double> sway(static_cast<std::size_t>(protocol.samples())), noise(sway.size());
  simulator.run(parameters, Random(5, sim::streams::vestibular_noise, item), sway);
  Random(5, sim::streams::sensor_noise, item).fill_normal(noise, 1);
  std::vector<float> recording;
  for (std::size_t i = 0; i < sway.size(); ++i)
    recording.push_back(static_cast<float>(sway[i] + noise_deg * sim::rad_per_deg * noise[i]));
  return recording;
}

}  // namespace decid::test
