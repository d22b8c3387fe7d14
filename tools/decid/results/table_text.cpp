// Tables as text: see table.hpp.
#ifndef __wasm__  // a page has no locales
#include <langinfo.h>

#include <clocale>
#endif

#include <algorithm>
#include <cmath>

#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
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

}  // namespace

CsvStyle parse_csv_style(const std::string& excel) {
  if (excel.empty()) return CsvStyle::plain;
  const bool comma = excel == "comma" || (excel == "locale" && has_decimal_comma());
  return comma ? CsvStyle::excel_comma : CsvStyle::excel_point;
}

std::string csv_text(const ResultTable& table, CsvStyle style) {
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

void write_table(const std::filesystem::path& path, const ResultTable& table, CsvStyle style) {
  if (lower_case(path.extension().string()) == ".xlsx") return write_xlsx(path, table);
  write_file(path, csv_text(table, style));
}

}  // namespace decid::tools
