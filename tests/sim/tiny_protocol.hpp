// The shortest experiment, for tests that need many trials of one.
#pragma once

#include "sim/protocol/protocol.hpp"

namespace decid::test {

/// 4 s at 100 Hz: 80 states of 50 ms. A tilt of 8 degrees makes some trials of it sway beyond 0.05 rad.
inline sim::Protocol tiny_protocol() {
  sim::Protocol protocol;
  protocol.name = "tiny";
  protocol.sequence().feedback = {0, 0, -1, 1};
  protocol.sequence().start = {0, 0, 0, 1};
  protocol.sequence().state_s = 0.05;
  protocol.sequence().amplitude_deg = 8.0;
  protocol.sequence().offset_s = 0.0;
  protocol.sequence().cycles = 1;
  return protocol;
}

}  // namespace decid::test
