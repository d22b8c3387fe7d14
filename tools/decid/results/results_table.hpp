// Results as a table for spreadsheets and R: a line a recording.
#pragma once

#include <string>

#include "base/files/json.hpp"
#include "sim/parameters.hpp"
#include "tools/decid/options.hpp"

namespace decid::tools {

/// CSV (RFC 4180, lines end in \n) of "recordings" as JSON has them: file, trust, each parameter's value and the ends
/// of its 90 % interval, and what was wrong with a recording that could not be used, whose other cells are empty.
/// Numbers read back to the same bits.
std::string results_table(const Json& recordings, const sim::ParameterTable& parameters);

/// --table, of the commands that write it.
void add_table_option(const Command& command, std::string& table);

}  // namespace decid::tools
