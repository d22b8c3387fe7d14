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
  std::string text;  ///< its table as a spreadsheet saves it as text: cells between tabs, a line for each row
  std::vector<std::string> sheets;  ///< names of those that are not hidden; the first one is read
};

/// Reads the first sheet that is not hidden. Numbers stand as the workbook stores them, so dates and times are days;
/// true and false are TRUE and FALSE; errors (#N/A) and missing cells are empty. Line k is row k. Throws Error for a
/// workbook that is damaged or protected, a first sheet without a table where another has one, and one without cells,
/// of more than 1000 columns or of more than 64 MiB.
Sheet read_xlsx(std::string_view bytes, const std::string& where);

}  // namespace decid::recording
