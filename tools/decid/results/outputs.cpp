// The files of a report: see outputs.hpp.
#include "tools/decid/results/outputs.hpp"

#include <iostream>

#include "base/files/file.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/decid/results/table.hpp"
#include "tools/report/fit_page.hpp"
#include "tools/report/identify_page.hpp"

namespace decid::tools {

void Outputs::check(std::vector<std::string> inputs) const {
  for (const std::string& path : files()) {
    refuse_same_file(path, inputs);
    inputs.push_back(path);
  }
  for (const std::string& path : files())
    if (!path.empty() && is_root()) PendingFile probe(path);  // reports an unwritable place before the work
}

void Outputs::write(const Report& report, bool print_json) const {
  const std::string text = print_json || !json.empty() ? report_json(report) : std::string();
  if (!draws.empty()) write_draws(draws, report, places, count);
  if (!page.empty()) write_file(page, report.fit ? fit_page(report) : identify_page(report));
  const CsvStyle style = csv_style_of(excel);
  if (!table.empty()) write_table(table, wide_table(report), style);
  if (!long_table.empty()) write_table(long_table, decid::tools::long_table(report), style);
  if (!json.empty()) write_file(json, text);
  std::cout << (print_json ? text : report_text(report));
}

void add_report_options(const Command& command, Outputs& outputs, bool of_fit) {
  add_output_option(command, "-o,--output", outputs.json, Written::json, "Write the results to this JSON file");
  if (of_fit)
    add_output_option(command, "--draws", outputs.draws, Written::draws,
                      "Write all draws to this NumPy file (.npz), or as CSV for R and Stan's tools (.csv)");
  add_output_option(command, "--report", outputs.page, Written::html,
                    "Write a report to this HTML page, which opens offline");
  add_output_option(command, "--table", outputs.table, Written::table,
                    "Write a table with one line per recording, as CSV or .xlsx, for spreadsheets and R");
  add_output_option(command, "--long", outputs.long_table, Written::table,
                    "Write a table with one line per recording and parameter, as CSV or .xlsx");
  command.section("Output");
  command
      .add_option("--excel", outputs.excel,
                  "Write CSV tables for Excel: with decimal commas (comma), points (point), or as the system's "
                  "language writes numbers (locale); default: points, for R and pandas")
      .one_of({"comma", "point", "locale"});
}

}  // namespace decid::tools
