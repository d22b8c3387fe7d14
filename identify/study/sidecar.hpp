// The JSON file beside a sheet of BIDS, "participants.json" of "participants.tsv", which describes its columns
// (BIDS 1.9, tabular files).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace decid {

/// Returns the sidecar of participants.tsv, *_sessions.tsv or *_scans.tsv; nothing if there is none, or for another
/// sheet.
std::optional<std::filesystem::path> sidecar_of(const std::filesystem::path& sheet);

/// Returns the `Units` that a sheet's sidecar gives for columns, by their names. Throws Error for a damaged sidecar.
std::map<std::string, std::string> sidecar_units(const std::filesystem::path& sheet);

}  // namespace decid
