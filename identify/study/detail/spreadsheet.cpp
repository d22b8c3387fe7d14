// Tables of text: see spreadsheet.hpp.
#include "identify/study/detail/spreadsheet.hpp"

#include <algorithm>
#include <utility>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/text.hpp"
#include "identify/study/detail/sheet_columns.hpp"
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

/// Splits text into cells. A quote opens a quoted text only at the start of a cell: in a remark it may mean inches.
class RowReader {
 public:
  RowReader(const std::string& text, char separator, const std::string& where)
      : text_(text), separator_(separator), where_(where) {}

  std::vector<std::vector<std::string>> operator()() {
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == separator_)
        begin_cell(rows_.back());
      else if (c == '\n')
        begin_row();
      else if (c == '"' && at_start_)
        read_quoted();
      else if (c != '\r')
        add(c);
    }
    return std::move(rows_);
  }

 private:
  void begin_cell(std::vector<std::string>& row) {
    row.emplace_back();
    at_start_ = true;
    quoted_lines_ = false;
  }
  void begin_row() {
    ++line_;
    begin_cell(rows_.emplace_back());
  }

  void add(char c) {
    const bool is_blank = c == ' ' || c == '\t';
    if (!is_blank && quoted_lines_) refuse_quote("whose pair in line " + std::to_string(line_) + " is within a cell");
    at_start_ = at_start_ && is_blank;
    rows_.back().back() += c;
  }

  /// Reads from a quote to its pair.
  void read_quoted() {
    std::string& cell = rows_.back().back();
    const std::size_t begin = cell.size();
    opened_ = line_;
    at_start_ = false;
    for (++at_; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == '"' && text_.compare(at_, 2, "\"\"") != 0) return end_quoted(cell.substr(begin));
      if (c == '"') ++at_;
      if (c == '\n') ++line_;
      cell += c;
    }
    refuse_quote("without a pair");
  }

  void end_quoted(const std::string& quoted) {
    quoted_lines_ = line_ > opened_;
    if (quoted_lines_ && separator_ == '\t' && quoted.find('\t') != std::string::npos)
      refuse_quote("whose pair is in line " + std::to_string(line_) + ", with tabs between them");
  }

  [[noreturn]] void refuse_quote(const std::string& problem) const {
    throw Error(Code::table_unclear, format("%s, line %zu", where_.c_str(), opened_),
                "has a cell that begins with a quote " + problem,
                "delete the quote, or put the cell in quotes and double each quote within");
  }

  const std::string& text_;
  char separator_;
  const std::string& where_;
  std::vector<std::vector<std::string>> rows_{std::vector<std::string>(1)};
  std::size_t at_ = 0, line_ = 1, opened_ = 0;  // opened_: the line of the last quoted text's first quote
  bool at_start_ = true;                        // of a cell, except for blanks
  bool quoted_lines_ = false;                   // the cell has a quoted text of several lines
};

/// Takes blanks from the ends of cells, and makes those within plain, except in the names of files.
void tidy(std::vector<std::vector<std::string>>& rows) {
  std::vector<bool> has_files;
  for (std::vector<std::string>& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      row[i] = recording::trim_all(row[i]);
      if (i >= has_files.size() || !has_files[i]) row[i] = recording::with_plain_blanks(std::move(row[i]));
    }
    if (has_files.empty())
      for (const SheetColumn& column : sheet_columns(row)) has_files.push_back(column.role == ColumnRole::file);
  }
}

}  // namespace

std::vector<std::vector<std::string>> read_spreadsheet(const std::filesystem::path& path) {
  std::string text = read_file(path, max_bytes);
  text = recording::is_xlsx(text) ? recording::read_xlsx(text, path.string(), {}, recording::DateCells::text).text
                                  : recording::to_utf8(std::move(text), path.string());
  if (text.starts_with("sep=")) text.erase(0, std::min(text.find('\n'), text.size() - 1) + 1);
  std::vector<std::vector<std::string>> rows = RowReader(text, separator_of(text), path.string())();
  tidy(rows);
  return rows;
}

}  // namespace decid
