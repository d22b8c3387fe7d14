// 30 s of sines in three cycles, for tests that need cycles and little time.
#pragma once

#include "sim/protocol.hpp"

namespace decid::test {

inline sim::Protocol three_sines() {
  sim::Protocol protocol;
  protocol.name = "sines";
  protocol.experiment.stimulus = sim::Sines{
      .components = {{.frequency_hz = 0.2, .amplitude_deg = 0.7}, {.frequency_hz = 0.6, .amplitude_deg = 0.3}},
      .cycle_s = 10.0,
      .cycles = 3};
  protocol.noise.vestibular.low_hz = 0.05;
  protocol.noise.vestibular.period_s = 60.0;
  return protocol;
}

}  // namespace decid::test
