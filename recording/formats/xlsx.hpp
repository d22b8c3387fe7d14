// Workbooks of Excel and LibreOffice (.xlsx) as text. Not installed.
// Format: ECMA-376 part 1, section 18: a zip archive of XML.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace decid::recording {

/// Returns true for an archive that holds a workbook.
bool is_xlsx(std::string_view bytes);

struct Sheet {
  std::string text;  ///< its table as text, as spreadsheets save it: cells between tabs, one line per row
  std::vector<std::string> sheets;  ///< names of the sheets that are not hidden
  bool is_named = false;            ///< the text is of the sheet that the caller named
};

/// Returns the first row of the first sheet that is not hidden, with tabs between its cells; empty for a file that is
/// not a workbook. Throws Error for a damaged one.
std::string read_first_row(std::string_view bytes, const std::string& where);

/// Cells that show a date: as the number of days that the workbook stores, or as a text such as "2026-03-05".
enum class DateCells { days, text };

/// Reads the sheet of this name, in any letter case, or the first one that is not hidden if no sheet has it. Keeps
/// numbers as the workbook stores them, so times are days, and dates too unless `dates` says otherwise. Writes true and
/// false as TRUE and FALSE; errors (#N/A) and missing cells become empty. Line k is row k. Throws Error for a damaged
/// or protected workbook, a formula whose value the workbook does not hold (openpyxl writes such), an unnamed first
/// sheet without a table if another sheet has one, and a sheet without cells, of more than 1000 columns or of more than
/// 64 MiB.
Sheet read_xlsx(std::string_view bytes, const std::string& where, const std::string& name = {},
                DateCells dates = DateCells::days);

}  // namespace decid::recording
