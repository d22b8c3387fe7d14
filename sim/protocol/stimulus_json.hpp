// Kinds of stimulus as JSON, one key each in a protocol. Not installed.
// Keys: the doc in protocol_json.hpp.
#pragma once

#include "base/files/json_object.hpp"
#include "sim/protocol/protocol_json.hpp"

namespace decid::sim {

/// Adds the stimulus to a protocol's object, under its key.
void write_stimulus(const StimulusKind& stimulus, Json& protocol);

/// Reads the stimulus of a protocol's object, if it has one. A measured tilt in a file is brought to sample_rate_hz.
/// Throws Error for several stimuli in one protocol, and for what the file's reading throws.
void read_stimulus(JsonObject& protocol, const ProtocolText& source, double sample_rate_hz, StimulusKind& stimulus);

}  // namespace decid::sim
