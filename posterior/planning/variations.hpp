// Protocols that differ from one in the size or the length of its stimulus, for plans.
#pragma once

#include "sim/protocol/protocol.hpp"

namespace decid::posterior {

/// Returns the protocol with a stimulus of this height, highest minus lowest tilt. Throws Error for a height that is
/// not above 0, and for a platform that does not move.
sim::Protocol with_peak_to_peak(sim::Protocol protocol, double degrees);
/// Returns the protocol with this number of cycles. Throws Error if such a protocol is invalid.
sim::Protocol with_cycles(sim::Protocol protocol, int cycles);

}  // namespace decid::posterior
