// Tables of results for spreadsheets, R and pandas: a line per recording (wide), or per recording and parameter (long);
// as CSV, as CSV for Excel, or as a workbook.
#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "identify/result.hpp"

namespace decid::tools {

/// An empty cell, a number or text. A number that is not finite is an empty cell.
using Cell = std::variant<std::monostate, double, std::string>;

struct ResultTable {
  std::vector<std::string> names;
  std::vector<std::vector<Cell>> rows;
  std::size_t copied_begin = 0, copied_end = 0;  ///< the columns that are copied from the study's sheet, as text
};

/// Returns a line per recording: file, trust; of each parameter NAME, NAME_low90, NAME_high90; then the study's
/// columns, the body, NAME_sd and NAME_normalized, codes, checks, and what computed it; last, the error of a recording
/// that could not be used, whose cells of results are empty.
ResultTable wide_table(const Report& report);
/// Returns a line per recording and parameter, with the same columns. A recording with an error has one line.
ResultTable long_table(const Report& report);

/// RFC 4180 with points; or Excel's: a byte order mark, and decimal commas with semicolons between cells, or decimal
/// points with commas.
enum class CsvStyle { plain, excel_comma, excel_point };
/// Returns the style for --excel: empty, "comma", "point", or "locale", which asks the system (LC_ALL, LC_NUMERIC,
/// LANG).
CsvStyle parse_csv_style(const std::string& excel);

/// Returns the table with numbers instead of the texts of each copied column that has only numbers, such as ages.
/// Numbers of persons ("007") stay texts, and so do decimal commas.
ResultTable with_numbers(ResultTable table);

/// Returns the table as CSV. Copied numbers have decimal commas too where Excel's have. Plain lines end in \n, Excel's
/// in \r\n. Numbers read back to the same bits.
std::string csv_text(ResultTable table, CsvStyle style);

/// Writes the table: a workbook if the path ends in .xlsx, with numbers in copied columns too, else CSV.
void write_table(const std::filesystem::path& path, ResultTable table, CsvStyle style);

/// Writes a workbook with one sheet, whose first row stays visible; the same table makes the same bytes. Format:
/// ECMA-376, by libxlsxwriter, which is loaded. Throws Error if decid was built without it, or it cannot be loaded.
void write_xlsx(const std::filesystem::path& path, const ResultTable& table);

}  // namespace decid::tools
