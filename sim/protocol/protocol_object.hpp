// A protocol as a JSON value, for files that have more in them. Not installed.
#pragma once

#include "base/files/json.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::sim {

/// Returns what to_json() prints (protocol_json.hpp).
Json json_of(const Protocol& protocol);

}  // namespace decid::sim
