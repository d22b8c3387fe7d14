// Kinds of stimulus as JSON, one key each in a protocol. Not installed. protocol_json.hpp documents the keys.
#pragma once

#include "base/files/json_object.hpp"
#include "sim/protocol/protocol_json.hpp"

namespace decid::sim {

/// Adds the stimulus to a protocol's object, under its key.
void write_stimulus(const StimulusKind& stimulus, Json& protocol);

/// Reads the stimulus of a protocol's object, if it has one. Resamples a measured tilt in a file to sample_rate_hz.
/// Throws Error for several stimuli in one protocol, and the errors of reading the file.
void read_stimulus(JsonObject& protocol, const ProtocolText& source, double sample_rate_hz, StimulusKind& stimulus);

}  // namespace decid::sim
