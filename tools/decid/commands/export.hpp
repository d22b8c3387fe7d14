// Functions that the commands of decid export share.
#pragma once

#include <string>

#include "base/files/json.hpp"
#include "tools/decid/options.hpp"
#include "tools/firmware/text.hpp"

namespace decid::tools {

enum class ExportedKind { model, controller };

/// Writes NAME.h and NAME.c in a folder, which it creates if it is missing. Throws Error if one of them is exported C
/// of the other kind, whose self-test takes another argument.
void write_exported(const std::string& folder, const std::string& name, ExportedKind kind, const FirmwareFiles& files);

/// Returns the JSON's keys of exported files: "files", their names, and "files_sha256".
Json written_json(const std::string& name, const FirmwareFiles& files);

/// Adds `export controller`.
void add_export_controller(const Command& parent);

}  // namespace decid::tools
