// Dates in workbooks: see workbook_dates.hpp.
#include "recording/formats/detail/workbook_dates.hpp"

#include <chrono>
#include <cmath>
#include <map>

#include "base/number.hpp"
#include "base/text.hpp"
#include "recording/formats/detail/xml_scanner.hpp"
#include "recording/table/cells.hpp"

namespace decid::recording {

namespace {

using Tag = XmlScanner::Tag;

// Excel's February of 1900 has a day too many.
constexpr double first_certain_day = 61.0, last_day = 2958465.0;  // until the end of 9999
constexpr double days_1900 = 25569.0, days_1904 = 24107.0, seconds_of_day = 86400.0;

/// Returns true for the formats of dates that files do not define: also those of East Asian editions.
bool is_date_number(int number) {
  return (number >= 14 && number <= 17) || number == 22 || (number >= 27 && number <= 31) || number == 36 ||
         (number >= 50 && number <= 54) || number == 57 || number == 58;
}

bool has_1904(std::string_view workbook, const std::string& where) {
  XmlScanner xml(workbook, where);
  for (Tag tag = xml.next(); tag != Tag::end; tag = xml.next()) {
    if (tag != Tag::open || xml.name() != "workbookPr") continue;
    const std::string value = xml.attribute("date1904");
    return value == "1" || value == "true";
  }
  return false;
}

}  // namespace

bool shows_date(std::string_view code) {
  char closes = 0;
  for (std::size_t i = 0; i < code.size(); ++i) {
    const char c = code[i];
    if (closes != 0) {
      if (c == closes) closes = 0;
    } else if (c == '"') {
      closes = '"';
    } else if (c == '[') {
      closes = ']';
    } else if (c == '\\' || c == '_' || c == '*') {
      ++i;  // the next character stands for itself
    } else if (c == ';') {
      return false;  // the formats of negative numbers and texts
    } else if (c == 'd' || c == 'D' || c == 'y' || c == 'Y') {
      return true;
    }
  }
  return false;
}

WorkbookDates::WorkbookDates(std::string_view styles, std::string_view workbook, const std::string& where)
    : first_day_(has_1904(workbook, where) ? days_1904 : days_1900) {
  XmlScanner xml(styles, where);
  std::map<int, bool> own;  // formats that the file defines
  bool in_cells = false;
  for (Tag tag = xml.next(); tag != Tag::end; tag = xml.next()) {
    if (xml.name() == "cellXfs") in_cells = tag == Tag::open;
    if (tag != Tag::open) continue;
    const int number = number_from<int>(xml.attribute("numFmtId")).value_or(0);
    if (xml.name() == "numFmt") own[number] = shows_date(xml.attribute("formatCode"));
    if (xml.name() != "xf" || !in_cells) continue;
    const auto found = own.find(number);
    is_date_.push_back(found == own.end() ? is_date_number(number) : found->second);
  }
}

std::string WorkbookDates::text(const std::string& days, const std::string& style) const {
  const std::size_t of_style = number_from<std::size_t>(style).value_or(0);
  const double value = parse_number(days).value;
  if (of_style >= is_date_.size() || !is_date_[of_style] || !(value >= first_certain_day && value < last_day))
    return days;
  const auto seconds = static_cast<long long>(std::floor((value - first_day_) * seconds_of_day + 0.5));
  const std::chrono::sys_seconds time{std::chrono::seconds(seconds)};
  const auto midnight = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date{midnight};
  std::string text = format("%04d-%02u-%02u", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                            static_cast<unsigned>(date.day()));
  const long long of_day = (time - midnight).count();
  if (of_day != 0) text += format("T%02lld:%02lld:%02lld", of_day / 3600, of_day / 60 % 60, of_day % 60);
  return text;
}

}  // namespace decid::recording
