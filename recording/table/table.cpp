// Opens a table by its kind of file: see table.hpp.
#include "recording/table/table.hpp"

#include <cmath>
#include <iostream>
#include <map>
#include <utility>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "recording/formats/csv.hpp"
#include "recording/formats/detail/c3d.hpp"
#include "recording/formats/detail/foreign.hpp"
#include "recording/formats/detail/mat/mat.hpp"
#include "recording/formats/motion_bids.hpp"
#include "recording/formats/xlsx.hpp"

namespace decid::recording {

namespace {

constexpr std::size_t file_limit_bytes = std::size_t{1} << 30;

std::string read_standard_input() {
  std::string text;
  std::vector<char> block(std::size_t{1} << 16);
  while (std::cin.read(block.data(), std::ssize(block)) || std::cin.gcount() > 0) {
    text.append(block.data(), static_cast<std::size_t>(std::cin.gcount()));
    if (text.size() > file_limit_bytes)
      throw Error(Code::file_too_large, "standard input", "is larger than 1 GiB", "give only one trial");
  }
  return text;
}

/// Throws Error for options on a table's position in a text, for files of another format.
void refuse_text_options(const std::string& where, const std::string& is, std::optional<int> skip_lines,
                         const std::string& section) {
  if (skip_lines)
    throw Error(Code::setting_conflict, where, "is a " + is + ", which has no lines above a table",
                "leave out " + setting("skip_lines"));
  if (!section.empty())
    throw Error(Code::setting_conflict, where, "is a " + is + ", which has no sections",
                "leave out " + setting("section"));
}

/// Reads a workbook's sheet with the rules for text: the sheet that `section` names, or the first one, of which
/// `section` may then be a table.
std::unique_ptr<Table> read_sheet(const std::string& bytes, const std::string& where, std::optional<int> skip_lines,
                                  const std::string& section) {
  Sheet sheet = read_xlsx(bytes, where, section);
  const std::vector<std::string>& names = sheet.sheets;
  const bool is_named = sheet.is_named;
  Warnings warnings;
  if (names.size() > 1 && !is_named)
    add_info(warnings, "sheet_assumed",
             "decid reads the sheet '" + names[0] + "', the first of " + std::to_string(names.size()) +
                 " of the workbook; " + setting("section") + " names another one");
  try {
    return std::make_unique<CsvTable>(std::move(sheet.text), where, skip_lines, is_named ? std::string() : section,
                                      std::move(warnings), true);
  } catch (const Error& error) {
    if (section.empty() || is_named || names.size() == 1) throw;
    throw Error(error.code(), error.where(),
                error.problem() + "; the workbook's sheets are '" + joined(names, "', '") + "'", error.remedy());
  }
}

}  // namespace

const std::vector<TableArray>& Table::arrays() const {
  static const std::vector<TableArray> none;
  return none;
}

void Table::number_kept_rows(const std::vector<std::size_t>& rows) {
  std::vector<std::size_t> of_file;
  for (const std::size_t row : rows) of_file.push_back(row_of_file(row));
  kept_ = std::move(of_file);
}

std::vector<double> Table::numbers_of_each(int column, std::size_t step, Missing missing) const {
  const std::vector<double> all = numbers(column, missing);
  std::vector<double> some;
  some.reserve(all.size() / step + 1);
  for (std::size_t row = 0; row < all.size(); row += step) some.push_back(all[row]);
  return some;
}

RowLabels Table::labels(int column) const {
  RowLabels labels;
  std::map<double, std::uint32_t> known;
  for (const double value : numbers(column, Missing::kept)) {
    const auto [found, is_new] =
        known.try_emplace(std::isnan(value) ? HUGE_VAL : value, static_cast<std::uint32_t>(labels.values.size()));
    if (is_new) labels.values.push_back(std::isfinite(value) ? format("%.15g", value) : std::string());
    labels.of_row.push_back(found->second);
  }
  return labels;
}

void require_whole(const Table& table, const std::string& where) {
  if (const std::size_t line = table.cut_line())
    throw Error(Code::file_damaged, where, "ends in the middle of line " + std::to_string(line),
                "complete the line, or delete it");
}

std::unique_ptr<Table> read_table(const std::filesystem::path& path, std::optional<int> skip_lines,
                                  const std::string& section) {
  const bool is_stdin = path == standard_input;
  const std::string where = is_stdin ? "standard input" : path.string();
  const std::string end = lower_case(path.extension().string());
  // Reading first gives the reason if a file cannot be read or is too large.
  std::string text = is_stdin ? read_standard_input() : read_file(path, file_limit_bytes);
  if (is_xlsx(text)) return read_sheet(text, where, skip_lines, section);
  refuse_foreign(text, where, end);
  if (is_c3d(text, end)) {
    refuse_text_options(where, "C3D file", skip_lines, section);
    return std::make_unique<C3dTable>(std::move(text), where);
  }
  if ((end == ".mat" && !text.starts_with("\x89HDF\r\n")) || text.starts_with("MATLAB ")) {
    if (is_stdin)
      throw Error(Code::not_supported, where, "is a MAT-file, which can only be read as a file", "give its name");
    refuse_text_options(where, "MAT-file", skip_lines, section);
    return std::make_unique<MatTable>(text, path);
  }
  if (text.starts_with("\x89HDF\r\n")) {
    throw Error(Code::file_unsupported, where, "is an HDF5 file that is not MATLAB's",
                "save the signals as a MAT-file (SciPy's savemat) or as CSV");
  }
  auto table = std::make_unique<CsvTable>(std::move(text), where, skip_lines, section);
  if (is_motion_bids(path)) read_motion_bids(path, *table);
  return table;
}

}  // namespace decid::recording
