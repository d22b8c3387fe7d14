// Groups of recordings: see group_file.hpp.
#include "tools/decid/group_file.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>

#include "base/error.hpp"
#include "base/file.hpp"
#include "base/text.hpp"
#include "dataset/recording/cells.hpp"
#include "dataset/recording/encoding.hpp"

namespace decid::tools {
namespace {

using Cells = std::vector<std::string>;

constexpr std::size_t most_bytes = std::size_t{1} << 22;  // of the table; each cell takes 32 in memory

/// Rows of cells; the file's lines count as rows, those without any text are kept, so that errors can name them.
std::vector<Cells> rows_of(const std::string& text, char separator) {
  std::vector<Cells> rows(1, Cells(1));
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

std::string trimmed(const std::string& text) {
  return std::string(dataset::trim(text));
}

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; });
  return text;
}

/// As spreadsheets of most languages write it: whichever stands first in the line of names.
char separator_of(const std::string& text) {
  const std::size_t at = text.find_first_of(",;\t\n");
  return at == std::string::npos || text[at] == '\n' ? ',' : text[at];
}

/// Whether `path` ends with the parts of `end`.
bool ends_with(const std::filesystem::path& path, const std::filesystem::path& end) {
  const auto from = end.lexically_normal(), of = path.lexically_normal();
  const auto parts = std::distance(from.begin(), from.end()), all = std::distance(of.begin(), of.end());
  return parts <= all && std::equal(from.begin(), from.end(), std::next(of.begin(), all - parts));
}

struct Table {
  std::size_t file, group;  ///< columns
  std::vector<Cells> rows;  ///< the first has the names
};

Table read_table(const std::string& name) {
  std::string text = dataset::to_utf8(read_file(name, most_bytes), name);
  if (text.starts_with("sep=")) text.erase(0, std::min(text.find('\n'), text.size() - 1) + 1);  // Excel's own line
  Table table{0, 0, rows_of(text, separator_of(text))};
  const Cells& names = table.rows.front();
  const auto column = [&](const char* wanted) {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (lower_case(trimmed(names[i])) == wanted) return i;
    throw Error(name + ", line 1", std::string("has no column \"") + wanted + "\"",
                "give a table with the columns file and group");
  };
  table.file = column("file");
  table.group = column("group");
  return table;
}

}  // namespace

std::vector<std::string> groups_of(const std::string& table_name, const std::vector<std::string>& recordings) {
  const Table table = read_table(table_name);
  std::vector<std::optional<std::string>> found(recordings.size());
  for (std::size_t row = 1; row < table.rows.size(); ++row) {
    const Cells& cells = table.rows[row];
    if (std::ranges::all_of(cells, [](const std::string& cell) { return trimmed(cell).empty(); })) continue;
    const std::string where = format("%s, line %zu", table_name.c_str(), row + 1);
    if (cells.size() <= std::max(table.file, table.group)) throw Error(where, "is too short", "give file and group");
    const std::string file = trimmed(cells[table.file]), group = trimmed(cells[table.group]);
    if (file.empty()) throw Error(where, "names no file", "give one, or take the line away");
    const std::string last = std::filesystem::path(file).filename().string();
    for (std::size_t i = 0; i < recordings.size(); ++i) {
      if (!recordings[i].ends_with(last) || !ends_with(recordings[i], file)) continue;
      if (found[i] && *found[i] != group)
        throw Error(where, recordings[i] + " is in group \"" + *found[i] + "\" already, and now in \"" + group + "\"",
                    "give each recording one group; a folder before the file's name tells two of one name apart");
      found[i] = group;
    }
  }
  std::vector<std::string> groups;
  std::set<std::string> names;
  const auto lacking = std::ranges::count_if(found, [](const auto& group) { return !group.has_value(); });
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    if (!found[i])
      throw Error(table_name, "has no line for " + recordings[i] + " (it lacks " + counted(lacking, "recording") + ")",
                  "add a line for each; an empty group keeps a recording out of the comparison");
    groups.push_back(*found[i]);
    if (!found[i]->empty()) names.insert(*found[i]);
  }
  if (names.size() < 2)
    throw Error(table_name, "puts the recordings in " + counted(static_cast<long long>(names.size()), "group"),
                "give two groups or more");
  return groups;
}

void add_group_option(const Command& command, std::string& table) {
  command.add_option("--group", table,
                     "CSV table with the columns file and group: means, deviations and Hedges' g of the groups");
}

}  // namespace decid::tools
