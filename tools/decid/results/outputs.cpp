// The files of a report: see outputs.hpp.
#include "tools/decid/results/outputs.hpp"

#include <filesystem>
#include <iostream>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/decid/results/table.hpp"
#include "tools/report/figures/result_figures.hpp"
#include "tools/report/fit_page.hpp"
#include "tools/report/identify_page.hpp"

namespace decid::tools {

namespace {

/// Throws Error if a figure would replace an input, or decid cannot write into the folder or create it.
void check_figures(const std::filesystem::path& name, const std::vector<std::string>& inputs) {
  const std::filesystem::path folder = name.has_filename() ? name : name.parent_path();
  for (const char* id : result_figure_ids)
    for (const char* ending : {".svg", ".csv"})
      refuse_same_file((folder / (std::string(id) + ending)).string(), inputs);
  std::error_code ignored;
  if (std::filesystem::is_directory(folder, ignored)) {
    if (is_root()) PendingFile probe(folder / (std::string(result_figure_ids.front()) + ".svg"));
  } else if (std::filesystem::exists(folder, ignored)) {
    throw Error(Code::file_unwritable, name.string(), "is a file", "give the name of a folder");
  } else if (is_root()) {
    PendingFile probe(folder);
  }
}

void write_figures(const std::filesystem::path& folder, const Report& report) {
  make_output_folder(folder);
  for (const Figure& figure : result_figures(report)) {
    write_file(folder / (figure.id + ".svg"), figure.svg);
    write_file(folder / (figure.id + ".csv"), figure.csv);
  }
}

}  // namespace

void Outputs::check(std::vector<std::string> inputs) const {
  const auto is_csv = [](const std::string& path) { return !path.empty() && !path.ends_with(".xlsx"); };
  if (!excel.empty() && !is_csv(table) && !is_csv(long_table))
    throw Error(Code::setting_conflict, "--excel", "applies to CSV tables, and this call writes none",
                "give --table or --long with a name ending in .csv; .xlsx opens in any language");
  for (const std::string& path : files()) {
    refuse_same_file(path, inputs);
    inputs.push_back(path);
  }
  for (const std::string& path : files())
    if (!path.empty() && is_root()) PendingFile probe(path);  // reports an unwritable place before the work
  if (!figures.empty()) check_figures(figures, inputs);
}

void Outputs::write(const Report& report, bool print_json) const {
  const std::string text = print_json || !json.empty() ? report_json(report) : std::string();
  if (!draws.empty()) write_draws(draws, report, places, count);
  if (!page.empty()) write_file(page, report.fit ? fit_page(report) : identify_page(report));
  write_tables(report);
  if (!figures.empty()) write_figures(figures, report);
  if (!json.empty()) write_file(json, text);
  std::cout << (print_json ? text : report_text(report));
}

void Outputs::refuse_alone(const Report& report, bool print_json) const {
  if (report.recordings.size() != 1 || !report.recordings.front().error) return;
  const std::string text = print_json || !json.empty() ? report_json(report) : std::string();
  write_tables(report);
  if (!json.empty()) write_file(json, text);
  if (print_json) std::cout << text;
  throw Error(*report.recordings.front().error);
}

void Outputs::write_tables(const Report& report) const {
  const CsvStyle style = parse_csv_style(excel);
  if (!table.empty()) write_table(table, wide_table(report), style);
  if (!long_table.empty()) write_table(long_table, decid::tools::long_table(report), style);
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
  add_output_option(command, "--figures", outputs.figures, Written::folder,
                    "Write figures into this folder, as SVG with their numbers as CSV: estimates by group, changes by "
                    "session and condition, frequency responses");
  command.section("Output");
  command
      .add_option("--excel", outputs.excel,
                  "Write CSV tables for Excel: with decimal commas (comma), points (point), or as numbers are written "
                  "in the system's language (locale); default: points, for R and pandas")
      .one_of({"comma", "point", "locale"})
      .unrecorded();
}

}  // namespace decid::tools
