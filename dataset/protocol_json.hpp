// Protocols as JSON: what --protocol FILE reads and what data sets and models carry.
// {"name": "...", a stimulus, "sample_rate_hz", "body": {"mass_kg", "com_height_m", "inertia_kgm2"},
//  "vestibular_noise": {"scale_deg", "low_hz", "high_hz", "exponent"}, "sensor_noise_deg": x | [low, high]}
// The stimulus is one of these, each also with "cycles", "lead_in_s", "lead_out_s" (sim/stimulus.hpp):
//   "sequence": {"feedback": [..], "start": [..], "state_s", "amplitude_deg", "offset_s"}
//   "measured": {"tilt_deg": [..]}, or {"file", "column", "unit": "deg" | "rad", "rate_hz"}
//   "sines": {"components": [{"frequency_hz", "amplitude_deg", "phase_deg"}, ..], "cycle_s"}
//   "raised_cosines": {"moves": [{"shape": "pulse" | "step", "start_s", "duration_s", "amplitude_deg"}, ..], "cycle_s"}
// The body may be {"subject": {"mass_kg", "height_m"}} instead: Winter's segments (sim/segments.hpp).
// Anything left out takes the default protocol's value, but offset_s beside feedback or start, which is 0 then; an
// unknown key, or one that stands twice, is an error. Every setting: docs/protocols.md.
#pragma once

#include <string>
#include <vector>

#include "sim/protocol.hpp"

namespace decid::dataset {

/// Complete JSON text, keys in the order above, doubles so that they read back to the same bits. Self-contained: a
/// measured tilt stands in it with all its samples, a subject as the body it makes.
std::string to_json(const sim::Protocol& protocol);

/// `where` names the source in errors. Throws Error for bad JSON, unknown keys, wrong types, and values that
/// Protocol::validate refuses, and for a measured tilt in a file: what data sets and models carry needs no other file.
sim::Protocol protocol_from_json(const std::string& text, const std::string& where);

/// A built-in protocol by name ("default", "short"), or else a JSON file. A measured tilt's file is relative to it; its
/// columns and times are found as in recordings (recording.hpp): the tilt is the column named, else the first called
/// tilt, platform, a_fs or the like, else the only one beside the time. It is resampled to the protocol's rate. A file
/// that says no name gives its own, without ".json". Throws Error as above, for a tilt whose unit is neither given nor
/// in the column's name, and for what Protocol::refuse_implausible refuses. `files` gets the names of the files that
/// were read.
sim::Protocol load_protocol(const std::string& name_or_path, std::vector<std::string>* files = nullptr);

}  // namespace decid::dataset
