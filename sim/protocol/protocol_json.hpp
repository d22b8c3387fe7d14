// Protocols as JSON: what --protocol FILE reads and what data sets and models carry.
// {"name": "...", a stimulus, "sample_rate_hz", "body": {"mass_kg", "com_height_m", "inertia_kgm2"},
//  "vestibular_noise": {"scale_deg", "low_hz", "high_hz", "exponent", "period_s"}, "sensor_noise_deg": x | [low, high],
//  "standing_s", "body_heights": [low, high], "recording": {..}}: the last three only where they say something
// The stimulus is one of these, each also with "cycles", "lead_in_s", "lead_out_s" (sim/protocol/stimulus.hpp):
//   "sequence": {"feedback": [..], "start": [..], "state_s", "amplitude_deg", "offset_s"}
//   "measured": {"tilt_deg": [..]}, or {"file", "column", "unit": "deg" | "rad", "rate_hz"}
//   "sines": {"components": [{"frequency_hz", "amplitude_deg", "phase_deg"}, ..], "cycle_s"}
//   "raised_cosines": {"moves": [{"shape": "pulse" | "step", "start_s", "duration_s", "amplitude_deg"}, ..], "cycle_s"}
// The body may be {"subject": {"mass_kg", "height_m"}} instead: Winter's segments (sim/segments.hpp).
// "period_s" may be "trial", the trial's length. Anything left out takes the default protocol's value, but offset_s
// beside feedback or start, which is 0 then; an unknown key, or one that stands twice, is an error. Every setting:
// docs/reference/protocols.md.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/protocol/protocol.hpp"

namespace decid::sim {

/// Complete JSON text: keys in the order above, doubles that read back to the same bits. Self-contained: it has a
/// measured tilt with all its samples, a subject as the body that it makes, the noise's period in seconds.
std::string to_json(const Protocol& protocol);

/// `where` names the source in errors. Throws Error for bad JSON, unknown keys, wrong types, and values that
/// Protocol::validate refuses, and for a measured tilt in a file: what data sets and models carry needs no other file.
/// Those that say no period of the vestibular noise were made when it was the trial's length, which it is then.
Protocol protocol_from_json(const std::string& text, const std::string& where);

/// A file of measured tilt, as a protocol's "measured" names it.
struct TiltFileReference {
  std::string file;    ///< relative to the protocol's own
  std::string column;  ///< name or number from 1; empty: found by name
  bool in_degrees = true;
  bool says_unit = false;  ///< else the column's name has to
  std::optional<double> rate_hz = {};
  bool is_cycle = false;  ///< its first sample follows its last: the protocol has several cycles
};
/// Its tilt in degrees at sample_rate_hz.
using ReadTilt = std::function<std::vector<double>(const TiltFileReference& file, double sample_rate_hz)>;

/// Where a protocol comes from.
struct ProtocolText {
  std::string where;             ///< names it in errors
  std::string name = "default";  ///< of a protocol without one
  ReadTilt read_tilt = {};       ///< empty: it may not name any file
};
/// protocol_from_json for what people write: it reads files of measured tilt, refuses what is no experiment
/// (Protocol::refuse_implausible), and a noise without a period has twice the trial's length, as the default has.
/// Without read_tilt it is protocol_from_json.
Protocol protocol_from_text(const std::string& text, const ProtocolText& source);

}  // namespace decid::sim
