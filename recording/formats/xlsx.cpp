// Workbooks as text: see xlsx.hpp. csv.hpp has the rules for the text.
#include "recording/formats/xlsx.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/number.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "recording/formats/detail/workbook_dates.hpp"
#include "recording/formats/detail/xml_scanner.hpp"
#include "recording/formats/detail/zip_member.hpp"
#include "recording/table/detail/sections.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

namespace {

using Tag = XmlScanner::Tag;

constexpr std::size_t max_sheet_rows = 1'048'576, max_text = std::size_t{1} << 26;
constexpr const char* workbook_part = "xl/workbook.xml";

[[noreturn]] void refuse_workbook(const std::string& where, const std::string& what) {
  throw Error(Code::file_damaged, where, "is a damaged workbook: " + what, "save it again, or save the sheet as CSV");
}

/// The paths of a workbook's parts by their identifiers, and the paths of its shared texts and styles.
struct Parts {
  std::map<std::string, std::string> by_id;
  std::string shared_strings, styles;
};

Parts read_parts(ZipMembers& members, const std::string& where) {
  Parts parts;
  const std::string text = members.read("xl/_rels/workbook.xml.rels");
  XmlScanner xml(text, where);
  for (Tag tag = xml.next(); tag != Tag::end; tag = xml.next()) {
    if (tag != Tag::open || xml.name() != "Relationship") continue;
    const std::string target = xml.attribute("Target");
    const std::string path = target.starts_with('/') ? target.substr(1) : "xl/" + target;
    parts.by_id.emplace(xml.attribute("Id"), path);
    if (xml.attribute("Type").ends_with("/sharedStrings")) parts.shared_strings = path;
    if (xml.attribute("Type").ends_with("/styles")) parts.styles = path;
  }
  return parts;
}

/// Returns the names and identifiers of the sheets that are not hidden.
std::vector<std::pair<std::string, std::string>> visible_sheets(ZipMembers& members, const std::string& where) {
  std::vector<std::pair<std::string, std::string>> sheets;
  const std::string text = members.read(workbook_part);
  XmlScanner xml(text, where);
  for (Tag tag = xml.next(); tag != Tag::end; tag = xml.next()) {
    if (tag != Tag::open || xml.name() != "sheet") continue;
    const std::string state = xml.attribute("state");
    if (state.empty() || state == "visible") sheets.emplace_back(xml.attribute("name"), xml.attribute("id"));
  }
  return sheets;
}

/// Returns the text of an element that may be in pieces ("is", "si"), without the pronunciation of Asian texts.
std::string read_text(XmlScanner& xml, std::string_view element) {
  std::string text;
  int pronunciations = 0;
  for (Tag tag = xml.next(); tag != Tag::end; tag = xml.next()) {
    if (xml.name() == "rPh") pronunciations += tag == Tag::open ? 1 : -1;
    if (tag == Tag::close && xml.name() == "t" && pronunciations == 0) text += xml.text();
    if (tag == Tag::close && xml.name() == element) break;
  }
  return text;
}

std::vector<std::string> read_shared_strings(ZipMembers& members, const std::string& part, const std::string& where) {
  std::vector<std::string> strings;
  if (part.empty()) return strings;
  const std::string text = members.read(part);
  XmlScanner xml(text, where);
  for (Tag tag = xml.next(); tag != Tag::end; tag = xml.next())
    if (tag == Tag::open && xml.name() == "si") {
      if (strings.size() == max_sheet_rows)
        throw Error(Code::file_too_large, where, "has more than a million texts", "save the sheet as CSV");
      strings.push_back(read_text(xml, "si"));
    }
  return strings;
}

/// Returns the column of a cell's reference, from 0: 27 for "AB12".
std::size_t column_in(std::string_view reference, std::size_t otherwise) {
  std::size_t column = 0;
  for (const char c : reference) {
    if (c < 'A' || c > 'Z' || column > max_columns) break;
    column = 26 * column + static_cast<std::size_t>(c - 'A' + 1);
  }
  return column == 0 ? otherwise : column - 1;
}

/// Returns a cell's content on one line, without separators of cells.
std::string plain(std::string text) {
  for (char& c : text) {
    if (c == '\t' || c == '\n' || c == '\r') c = ' ';
    if (c == '"') c = '\'';
  }
  return text;
}

/// Reads a sheet's cells.
class SheetReader {
 public:
  SheetReader(std::string_view text, const std::vector<std::string>& shared, const WorkbookDates& dates,
              const std::string& where)
      : xml_(text, where), shared_(shared), dates_(dates), where_(where) {}

  /// Returns the first rows as text.
  std::string read(std::size_t max_rows = max_sheet_rows) {
    for (Tag tag = xml_.next(); tag != Tag::end; tag = xml_.next()) {
      if (tag == Tag::close && xml_.name() == "row" && rows_.size() >= max_rows) break;
      if (tag != Tag::open) continue;
      if (xml_.name() == "row") begin_row();
      if (xml_.name() == "c") read_cell();
    }
    return joined();
  }

 private:
  /// A row as text, and its number of cells.
  struct Row {
    std::string text;
    std::size_t cells = 0;
  };

  void begin_row() {
    const std::size_t row = number_from<std::size_t>(xml_.attribute("r")).value_or(rows_.size() + 1);
    if (row <= rows_.size() || row > max_sheet_rows) refuse_workbook(where_, "its rows are out of order");
    rows_.resize(row);
    next_column_ = 0;
  }

  void read_cell() {
    if (rows_.empty()) refuse_workbook(where_, "a cell lies outside of all rows");
    const std::size_t column = column_in(xml_.attribute("r"), next_column_);
    next_column_ = column + 1;
    if (column < rows_.back().cells) refuse_workbook(where_, "its cells are out of order");
    const std::string kind = xml_.attribute("t"), style = xml_.attribute("s");
    const std::string reference = xml_.attribute("r");
    const std::string value = read_value(kind, style, reference);
    if (value.empty()) return;  // a cell with only a format
    if (column >= max_columns)
      throw Error(Code::file_too_large, where_, "has more than 1000 columns", "give a sheet of at most 1000");
    append(rows_.back(), column, plain(value));
  }

  std::string read_value(const std::string& kind, const std::string& style, const std::string& reference) {
    std::string value;
    bool is_formula = false;
    for (Tag tag = xml_.next(); tag != Tag::end; tag = xml_.next()) {
      if (tag == Tag::open && xml_.name() == "f") is_formula = true;
      if (tag == Tag::open && xml_.name() == "is") value = read_text(xml_, "is");
      if (tag == Tag::close && xml_.name() == "v") value = xml_.text();
      if (tag == Tag::close && xml_.name() == "c") break;
    }
    if (is_formula && value.empty() && kind != "str")
      throw Error(Code::value_missing, where_,
                  "has a formula without a stored value in " +
                      (reference.empty() ? format("row %zu", rows_.size()) : "cell " + reference),
                  "open the workbook in Excel or LibreOffice and save it, or write the value instead of the formula");
    if (kind == "e") return {};
    if (kind == "b" && !value.empty()) return value == "0" ? "FALSE" : "TRUE";
    if (kind.empty() || kind == "n") return dates_.text(value, style);
    if (kind != "s") return value;
    const std::size_t index = number_from<std::size_t>(value).value_or(shared_.size());
    if (index >= shared_.size()) refuse_workbook(where_, "a cell's text is missing");
    return shared_[index];
  }

  void append(Row& row, std::size_t column, const std::string& value) {
    const std::size_t tabs = row.cells == 0 ? column : column - row.cells + 1;
    count(tabs + value.size());
    row.text.append(tabs, '\t');
    row.text += value;
    row.cells = column + 1;
    width_ = std::max(width_, row.cells);
  }

  /// Returns all rows; rows with cells get equal lengths.
  std::string joined() {
    std::string text;
    for (const Row& row : rows_) {
      const std::size_t missing = row.cells == 0 ? 0 : width_ - row.cells;
      count(missing + 1);
      text += row.text + std::string(missing, '\t') + '\n';
    }
    return text;
  }

  void count(std::size_t bytes) {
    bytes_ += bytes;
    if (bytes_ > max_text)
      throw Error(Code::file_too_large, where_, "is larger than 64 MiB as text", "save only one trial");
  }

  XmlScanner xml_;
  const std::vector<std::string>& shared_;
  const WorkbookDates& dates_;
  const std::string& where_;
  std::vector<Row> rows_;
  std::size_t next_column_ = 0, width_ = 0, bytes_ = 0;
};

/// Throws Error if a sheet after the first one holds a table.
void refuse_without_table(const std::vector<std::pair<std::string, std::string>>& sheets, const Parts& parts,
                          const std::function<std::string(const std::string&)>& read, const std::string& asked,
                          const std::string& where) {
  std::string list;
  for (std::size_t i = 1; i < sheets.size(); ++i) {
    const auto part = parts.by_id.find(sheets[i].second);
    try {
      if (part == parts.by_id.end() || find_sections(read(part->second)).empty()) continue;
    } catch (const Error&) {  // a chart, or a damaged sheet
      continue;
    }
    list += (list.empty() ? "'" : ", '") + sheets[i].first + "'";
  }
  if (!list.empty())
    throw Error(Code::file_empty, where,
                (asked.empty() ? "has no table in its first sheet '"
                               : "has no sheet '" + asked + "', and no table in its first sheet '") +
                    sheets[0].first + "'; tables are in " + list,
                "move the table's sheet to the front, or name a recording's sheet with " + setting("section"));
}

}  // namespace

bool is_xlsx(std::string_view bytes) {
  return bytes.starts_with("PK\x03\x04") && bytes.find(workbook_part) != bytes.npos;
}

std::string read_first_row(std::string_view bytes, const std::string& where) {
  if (!is_xlsx(bytes)) return {};
  ZipMembers members(bytes, where);
  const auto sheets = visible_sheets(members, where);
  const Parts parts = read_parts(members, where);
  const auto part = sheets.empty() ? parts.by_id.end() : parts.by_id.find(sheets.front().second);
  if (part == parts.by_id.end()) return {};
  const std::vector<std::string> shared = read_shared_strings(members, parts.shared_strings, where);
  const std::string xml = members.read(part->second);
  return SheetReader(xml, shared, WorkbookDates(), where).read(1);
}

Sheet read_xlsx(std::string_view bytes, const std::string& where, const std::string& name, DateCells dates) {
  ZipMembers members(bytes, where);
  const auto sheets = visible_sheets(members, where);
  if (sheets.empty()) refuse_workbook(where, "it has no sheet");
  const Parts parts = read_parts(members, where);
  Sheet sheet;
  for (const auto& one : sheets) sheet.sheets.push_back(one.first);
  const auto named =
      std::ranges::find_if(sheets, [&](const auto& one) { return lower_case(one.first) == lower_case(name); });
  sheet.is_named = !name.empty() && named != sheets.end();
  const auto& [title, id] = sheet.is_named ? *named : sheets.front();
  const std::string which = sheet.is_named ? "sheet '" + title + "'" : "first sheet";
  const auto part = parts.by_id.find(id);
  if (part == parts.by_id.end()) refuse_workbook(where, "its " + which + " is missing");
  const std::vector<std::string> shared = read_shared_strings(members, parts.shared_strings, where);
  WorkbookDates formats;
  if (dates == DateCells::text && !parts.styles.empty())
    formats = WorkbookDates(members.read(parts.styles), members.read(workbook_part), where);
  const auto read = [&](const std::string& part_name) {
    const std::string xml = members.read(part_name);
    return SheetReader(xml, shared, formats, where).read();
  };
  sheet.text = read(part->second);
  if (!sheet.is_named && find_sections(sheet.text).empty()) refuse_without_table(sheets, parts, read, name, where);
  if (sheet.text.find_first_not_of('\n') == sheet.text.npos)
    throw Error(
        Code::file_empty, where, "has a " + which + " without cells",
        sheet.is_named ? "name another sheet with " + setting("section") : "move the recording to the first sheet");
  return sheet;
}

}  // namespace decid::recording
