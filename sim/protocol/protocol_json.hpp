// Protocols as JSON, as in protocol files, data sets and models.
// {"name": "...", a stimulus, "sample_rate_hz", "body": {"mass_kg", "com_height_m", "inertia_kgm2"},
//  "vestibular_noise": {"scale_deg", "low_hz", "high_hz", "exponent", "period_s"}, "sensor_noise_deg": x | [low, high],
//  "standing_s", "moved_before", "gravity_dead_band_deg", "body_heights": [low, high], "recording": {..}}: the last
//  five only if they differ from the default, as "controller", the name of a model (sim/body_model.hpp), after the name
// The stimulus is one of these, each also with "cycles", "lead_in_s", "lead_out_s" (sim/protocol/stimulus.hpp):
//   "sequence": {"feedback": [..], "start": [..], "state_s", "amplitude_deg", "offset_s"}
//   "measured": {"tilt_deg": [..]}, or {"file", "column", "unit": "deg" | "rad", "rate_hz"}
//   "sines": {"components": [{"frequency_hz", "amplitude_deg", "phase_deg"}, ..], "cycle_s"}
//   "raised_cosines": {"moves": [{"shape": "pulse" | "step", "start_s", "duration_s", "amplitude_deg"}, ..], "cycle_s"}
// The body may be {"participant": {"mass_kg", "height_m"}} instead: Winter's segments (sim/segments.hpp). "period_s"
// may be "trial", the trial's length. Missing settings take the default protocol's value, except offset_s, which is 0
// if feedback or start is given. An unknown or repeated key is an error. docs/reference/protocols.md describes every
// setting.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/protocol/protocol.hpp"

namespace decid::sim {

/// Returns complete JSON text: keys in the order above, doubles that restore the same bits. It is self-contained: a
/// measured tilt has all samples, a participant becomes its body, and the noise's period is in seconds.
std::string to_json(const Protocol& protocol);

/// Reads a protocol; `where` names the source in errors. Throws Error for bad JSON, unknown keys, wrong types, and
/// values that Protocol::validate refuses. Throws Error for a measured tilt in a file, because data sets and models
/// must not depend on other files. A protocol without a period of the vestibular noise gets the trial's length, the
/// only period of older versions.
Protocol protocol_from_json(const std::string& text, const std::string& where);

/// A file of measured tilt, as a protocol's "measured" names it.
struct TiltFileReference {
  std::string file;    ///< relative to the protocol's own
  std::string column;  ///< name or number from 1; empty: found by name
  bool in_degrees = true;
  bool says_unit = false;  ///< else the column's name must have one
  std::optional<double> rate_hz = {};
  bool is_cycle = false;  ///< the first sample follows the last: the protocol has several cycles
};
/// Returns the file's tilt in degrees at sample_rate_hz.
using ReadTilt = std::function<std::vector<double>(const TiltFileReference& file, double sample_rate_hz)>;

/// The source of a protocol.
struct ProtocolText {
  std::string where;                                 ///< of the source, in errors
  std::string name = "default";                      ///< of a protocol without a name
  ReadTilt read_tilt = {};                           ///< empty: the protocol must not name files
  const BodyModel* controller = &single_pendulum();  ///< of a protocol without a controller
};
/// Reads a protocol as protocol_from_json does, for texts that users write. It reads files of measured tilt and refuses
/// settings that are not an experiment (Protocol::refuse_implausible). A noise without a period gets twice the trial's
/// length, like the default. Without read_tilt it equals protocol_from_json.
Protocol protocol_from_text(const std::string& text, const ProtocolText& source);

}  // namespace decid::sim
