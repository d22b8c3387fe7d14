// Protocols as JSON: what --protocol FILE reads and what data sets and models carry.
// {"name": "...", "sequence": {"feedback": [..], "start": [..], "state_s", "amplitude_deg", "offset_s", "cycles",
//  "lead_in_s", "lead_out_s"}, "sample_rate_hz", "body": {"mass_kg", "com_height_m", "inertia_kgm2"},
//  "vestibular_noise": {"scale_deg", "low_hz", "high_hz", "exponent"}, "sensor_noise_deg": x | [low, high]}
// Anything left out takes the default protocol's value; an unknown key is an error.
#pragma once

#include <filesystem>
#include <string>

#include "sim/protocol.hpp"

namespace decid::dataset {

/// Complete JSON text, keys in the order above, doubles so that they read back to the same bits.
std::string to_json(const sim::Protocol& protocol);

/// `where` names the source in errors. Throws Error for bad JSON, unknown keys, wrong types, and values that
/// Protocol::validate refuses.
sim::Protocol protocol_from_json(const std::string& text, const std::string& where);

/// A built-in protocol by name ("default", "short"), or else a JSON file.
sim::Protocol load_protocol(const std::string& name_or_path);

}  // namespace decid::dataset
