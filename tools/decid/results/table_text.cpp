// Tables as text: see table.hpp.
#ifndef __wasm__  // a page has no locales
#include <langinfo.h>

#include <clocale>
#endif

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/number.hpp"
#include "base/text.hpp"
#include "tools/decid/results/table.hpp"

namespace decid::tools {
namespace {

constexpr const char* byte_order_mark = "\xEF\xBB\xBF";

bool has_decimal_comma() {
#ifndef __wasm__
  const locale_t locale = ::newlocale(LC_NUMERIC_MASK, "", locale_t{});
  if (locale == locale_t{}) return false;  // the system has no such locale
  const bool comma = std::string(::nl_langinfo_l(RADIXCHAR, locale)) == ",";
  ::freelocale(locale);
  return comma;
#else
  return false;
#endif
}

/// Returns a number as JSON prints it; a file's name need not be UTF-8, so other bytes of text are replaced.
std::string cell_text(const Cell& cell, CsvStyle style) {
  if (const double* const number = std::get_if<double>(&cell)) {
    std::string text = std::isfinite(*number) ? Json(*number).dump() : std::string();
    if (style == CsvStyle::excel_comma) std::ranges::replace(text, '.', ',');
    return text;
  }
  const std::string* const text = std::get_if<std::string>(&cell);
  if (text == nullptr) return {};
  std::string made = csv_cell(valid_utf8(*text));
  const bool needs_quotes =
      style == CsvStyle::excel_comma && !made.starts_with('"') && made.find(';') != std::string::npos;
  return needs_quotes ? '"' + made + '"' : made;
}

/// Returns the number in a text such as "-1.5" that loses nothing as a number: not "007", "1e3" or more than 15 digits.
std::optional<double> plain_number(const Cell& cell) {
  const std::string* const text = std::get_if<std::string>(&cell);
  if (text == nullptr) return std::nullopt;
  const std::string_view digits = std::string_view(*text).substr(text->starts_with('-') ? 1 : 0);
  const std::size_t point = std::min(digits.find('.'), digits.size());
  if (digits.size() > 15 || point == 0 || point + 1 == digits.size() || (digits.front() == '0' && point > 1) ||
      digits.find_first_not_of("0123456789.") != digits.npos)
    return std::nullopt;
  return number_from<double>(*text);
}

}  // namespace

ResultTable with_numbers(ResultTable table) {
  const auto is_empty = [](const Cell& cell) { return std::holds_alternative<std::monostate>(cell); };
  for (std::size_t c = table.copied_begin; c < table.copied_end; ++c) {
    if (!std::ranges::all_of(table.rows, [&](const auto& row) { return is_empty(row[c]) || plain_number(row[c]); }))
      continue;
    for (std::vector<Cell>& row : table.rows)
      if (const std::optional<double> value = plain_number(row[c])) row[c] = *value;
  }
  return table;
}

CsvStyle parse_csv_style(const std::string& excel) {
  if (excel.empty()) return CsvStyle::plain;
  const bool comma = excel == "comma" || (excel == "locale" && has_decimal_comma());
  return comma ? CsvStyle::excel_comma : CsvStyle::excel_point;
}

std::string csv_text(ResultTable table, CsvStyle style) {
  if (style == CsvStyle::excel_comma) table = with_numbers(std::move(table));
  const char separator = style == CsvStyle::excel_comma ? ';' : ',';
  const std::string line_end = style == CsvStyle::plain ? "\n" : "\r\n";
  std::string text = style == CsvStyle::plain ? "" : byte_order_mark;
  const auto add = [&](const auto& cells, const auto& to_text) {
    for (std::size_t i = 0; i < cells.size(); ++i) text += (i > 0 ? std::string(1, separator) : "") + to_text(cells[i]);
    text += line_end;
  };
  add(table.names, [&](const std::string& name) { return cell_text(name, style); });
  for (const std::vector<Cell>& row : table.rows) add(row, [&](const Cell& cell) { return cell_text(cell, style); });
  return text;
}

void write_table(const std::filesystem::path& path, ResultTable table, CsvStyle style) {
  if (lower_case(path.extension().string()) == ".xlsx") return write_xlsx(path, with_numbers(std::move(table)));
  write_file(path, csv_text(std::move(table), style));
}

}  // namespace decid::tools
