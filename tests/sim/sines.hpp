// Short protocols of sines for tests.
#pragma once

#include "sim/protocol/protocol.hpp"

namespace decid::test {

/// Two sines in cycles, and noise of that period.
inline sim::Protocol sines(double slow_hz, double fast_hz, double cycle_s, int cycles, double noise_period_s) {
  sim::Protocol protocol;
  protocol.name = "sines";
  protocol.experiment.stimulus = sim::Sines{
      .components = {{.frequency_hz = slow_hz, .amplitude_deg = 0.7}, {.frequency_hz = fast_hz, .amplitude_deg = 0.3}},
      .cycle_s = cycle_s,
      .cycles = cycles};
  protocol.noise.vestibular.low_hz = 0.05;
  protocol.noise.vestibular.period_s = noise_period_s;
  return protocol;
}

/// 30 s in three cycles, for tests that need cycles and little time.
inline sim::Protocol three_sines() {
  return sines(0.2, 0.6, 10.0, 3, 60.0);
}

}  // namespace decid::test
