// A protocol as a JSON value, for files that have more in them. Not installed.
#pragma once

#include "base/files/json.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::sim {

/// Returns what to_json() prints (protocol_json.hpp).
Json to_json_object(const Protocol& protocol);

}  // namespace decid::sim
