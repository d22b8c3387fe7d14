// Tables of text: see spreadsheet.hpp.
#include "identify/study/spreadsheet.hpp"

#include <algorithm>

#include "base/files/file.hpp"
#include "recording/formats/encoding.hpp"
#include "recording/formats/xlsx.hpp"
#include "recording/table/cells.hpp"

namespace decid {
namespace {

constexpr std::size_t max_bytes = std::size_t{1} << 22;  // each cell takes 32 in memory

/// Returns the separator that stands first in the line of names: spreadsheets of most languages write their own.
char separator_of(const std::string& text) {
  const std::size_t at = text.find_first_of(",;\t\n");
  return at == std::string::npos || text[at] == '\n' ? ',' : text[at];
}

std::vector<std::vector<std::string>> rows_of(const std::string& text, char separator) {
  std::vector<std::vector<std::string>> rows(1, std::vector<std::string>(1));
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    std::string& cell = rows.back().back();
    if (c == '"' && quoted && i + 1 < text.size() && text[i + 1] == '"') {
      cell += text[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == separator && !quoted) {
      rows.back().emplace_back();
    } else if (c == '\n' && !quoted) {
      rows.emplace_back(1);
    } else if (c != '\r' || quoted) {
      cell += c;
    }
  }
  return rows;
}

}  // namespace

std::vector<std::vector<std::string>> read_spreadsheet(const std::filesystem::path& path) {
  std::string text = read_file(path, max_bytes);
  text = recording::is_xlsx(text) ? recording::read_xlsx(text, path.string()).text
                                  : recording::to_utf8(std::move(text), path.string());
  if (text.starts_with("sep=")) text.erase(0, std::min(text.find('\n'), text.size() - 1) + 1);
  std::vector<std::vector<std::string>> rows = rows_of(text, separator_of(text));
  for (std::vector<std::string>& row : rows)
    for (std::string& cell : row) cell = std::string(recording::trim(cell));
  return rows;
}

}  // namespace decid
