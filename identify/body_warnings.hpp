// Bodies that few people have.
#pragma once

#include "base/warning.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid {

/// Returns a caution (`implausible_body`) for a person with a body mass index that few people have, as a weight in
/// pounds gives; none for a body that is not a person's. sim::body_of_participant() refuses indexes outside 12 to 60
/// kg/m2.
Warnings body_warnings(const sim::Body& body);

}  // namespace decid
