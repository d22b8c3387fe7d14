// A protocol as a JSON value, for files that have more in them. Not installed.
#pragma once

#include <string>

#include "base/files/json.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::sim {

/// Returns what to_json() prints (protocol_json.hpp).
Json to_json_object(const Protocol& protocol);

/// Reads a protocol as protocol_from_json() does (protocol_json.hpp). where: for messages.
Protocol protocol_from_object(const Json& json, const std::string& where);

}  // namespace decid::sim
