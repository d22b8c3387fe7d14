// Protocols in files, with the recordings of measured tilt that they name. sim/protocol/protocol_json.hpp reads the
// text.
#pragma once

#include <string>
#include <vector>

#include "base/warning.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {

/// Loads a built-in protocol by name ("default", "short"), or a JSON file. The path of a measured tilt is relative to
/// that file. Its columns and times are found as in recordings (recording.hpp): the tilt is the named column, else the
/// first called tilt, platform, a_fs or similar, else the only column except the time. It is resampled to the
/// protocol's rate. A file without a name field gives its file name, without ".json". Throws Error as
/// sim::protocol_from_json does, for a tilt whose unit is neither given nor in the column's name, and for protocols
/// that Protocol::refuse_implausible refuses. controller: name of the controller (sim/body_model.hpp), empty: the one
/// of the protocol; throws Error if there is none of this name, and if the file names another one. Adds the names of
/// the files read to `files`, and to `warnings` what was left out of a measured tilt's file.
sim::Protocol load_protocol(const std::string& name_or_path, std::vector<std::string>* files = nullptr,
                            Warnings* warnings = nullptr, const std::string& controller = {});

}  // namespace decid::recording
