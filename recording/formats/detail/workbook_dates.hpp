// Which cells of a workbook are dates, and what they say. Not installed.
// Format: ECMA-376 part 1, 18.8.10 (cellXfs), 18.8.30 (numFmt), 18.17.4 (dates and times).
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace decid::recording {

/// The formats of a workbook's cells that show a date.
class WorkbookDates {
 public:
  /// Without dates: every number stays one.
  WorkbookDates() = default;
  /// styles, workbook: the parts of these names. `where` names the file. Throws Error for text that is not XML.
  WorkbookDates(std::string_view styles, std::string_view workbook, const std::string& where);

  /// Returns a cell's number of days as "2026-03-05" or "2026-03-05T12:03:04", rounded to seconds, if a cell of this
  /// style (its attribute "s") shows a date; otherwise the text as it is. Dates before March 1900 also stay numbers.
  std::string text(const std::string& days, const std::string& style) const;

 private:
  std::vector<bool> is_date_;   ///< by style
  double first_day_ = 25569.0;  ///< days from the workbook's day 0 to January 1, 1970
};

/// Returns true for a format's code with a day or a year, such as "dd/mm/yyyy" or "[$-409]d-mmm-yy".
bool shows_date(std::string_view code);

}  // namespace decid::recording
