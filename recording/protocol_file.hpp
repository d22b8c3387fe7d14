// Protocols in files, with the recordings of measured tilt that they name. The text itself:
// sim/protocol/protocol_json.hpp.
#pragma once

#include <string>
#include <vector>

#include "base/warning.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {

/// A built-in protocol by name ("default", "short"), or else a JSON file. A measured tilt's file is relative to it; its
/// columns and times are found as in recordings (recording.hpp): the tilt is the column named, else the first called
/// tilt, platform, a_fs or the like, else the only one beside the time. It is resampled to the protocol's rate. A file
/// that says no name gives its own, without ".json". Throws Error as sim::protocol_from_json does, for a tilt whose
/// unit is neither given nor in the column's name, and for what Protocol::refuse_implausible refuses. `files` gets the
/// names of the files that were read, `warnings` what was left out of a measured tilt's file (read_tilt_deg).
sim::Protocol load_protocol(const std::string& name_or_path, std::vector<std::string>* files = nullptr,
                            Warnings* warnings = nullptr);

}  // namespace decid::recording
