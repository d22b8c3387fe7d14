// The files that a command writes of its report, and what it prints.
#pragma once

#include <string>
#include <vector>

#include "identify/result.hpp"
#include "tools/decid/command.hpp"

namespace decid::tools {

struct Outputs {
  std::string json, page, table, long_table, draws;  ///< files; empty: not asked for
  std::string figures;                               ///< a folder; empty: not asked for
  std::string excel;                                 ///< --excel
  /// The places of the report's recordings in a call of `count`.
  std::vector<std::size_t> places = {};
  std::size_t count = 0;

  std::vector<std::string> files() const { return {json, draws, page, table, long_table}; }
  /// Returns true if an output shows hashes of the model and of inputs.
  bool needs_hashes() const { return !json.empty() || !page.empty() || !table.empty() || !long_table.empty(); }
  /// Throws Error if one of them would replace an input or another one, or cannot be written. Leaves no file.
  void check(std::vector<std::string> inputs) const;
  /// Writes the files and prints the report on standard output, as JSON or as text.
  void write(const Report& report, bool print_json) const;
  /// Throws the error of a single recording, after its JSON and its tables are written as write() does. With several
  /// recordings, each keeps its own error.
  void refuse_alone(const Report& report, bool print_json) const;

 private:
  void write_tables(const Report& report) const;
};

/// Adds -o, --report, --table, --long, --excel and --figures, of a fit also --draws.
void add_report_options(const Command& command, Outputs& outputs, bool of_fit);

}  // namespace decid::tools
