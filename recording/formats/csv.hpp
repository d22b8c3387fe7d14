// Tables of numbers as text: separated by commas, semicolons, tabs or blanks, with or without a header line.
// Not installed. Format: RFC 4180 and the variants of spreadsheets, MATLAB and NumPy; see CsvTable.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/table/cells.hpp"
#include "recording/table/detail/preamble.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// A table over its text. Numbers are parsed only for requested columns, so other columns may hold anything.
///
/// Accepted: UTF-8, UTF-16 and Windows-1252; lines that end in LF, CR LF or CR; blank lines; comment lines (# or %);
/// blanks around cells; quoted cells (on one line); a separator at the end of the lines; a decimal comma that cannot be
/// a separator ("1,5;2,7", "1,5 2,7", a single column); lines above the table (preamble.hpp). A line of units below the
/// header ("s,deg", "[s];[Grad]") becomes part of the names: "time (s)". A blank line between the rows of one column is
/// a row without a value, unless all rows have as many between them. A last line that ends in the middle is left out,
/// with a warning: one that lacks cells or ends in a part of a number. Fewer decimals than in the rows above count from
/// 20 rows on; people type short tables.
class CsvTable final : public Table {
 public:
  /// Reads a table. `where` names the file. `skip_lines`: the number of lines above the table; empty: decid finds it.
  /// `section`: one of several tables (sections.hpp); empty: the only one. `warnings`: warnings of earlier steps.
  /// `is_sheet`: the text is a workbook's sheet, which errors tell how to edit.
  /// Throws Error for a negative `skip_lines`, without lines of data, for rows of different length, and for too many
  /// rows or columns.
  CsvTable(std::string text, std::string where, std::optional<int> skip_lines = {}, const std::string& section = {},
           Warnings warnings = {}, bool is_sheet = false);

  std::size_t rows(int) const override { return rows_.size(); }
  bool has_header() const override { return has_header_; }
  /// Returns the header's names, else "column 1", "column 2", ...
  const std::vector<std::string>& names() const override { return names_; }
  std::vector<double> numbers(int column, Missing missing = Missing::refused) const override;
  std::vector<double> numbers_of_each(int column, std::size_t step, Missing missing) const override;
  /// Returns times, with the nanoseconds that a second column adds to whole seconds (nanoseconds_beside()). Clock
  /// times, with or without a date, become seconds since the midnight before the first. A time without a date that is
  /// more than 12 h before the last one is of the next day.
  std::vector<double> times(int column) const override;
  /// Returns the line of the file, from 1.
  std::string locate(std::size_t row) const override;
  const std::vector<StatedRate>& stated_rates() const override { return preamble_.rates; }
  std::optional<Unit> unit() const override { return preamble_.unit; }
  std::size_t preamble_lines() const override { return preamble_.lines; }
  const Warnings& warnings() const override { return warnings_; }
  std::size_t cut_line() const override { return cut_line_; }
  RowLabels labels(int column) const override;
  std::string label(int column, std::size_t row) const override;
  void keep_rows(int column, const std::vector<std::size_t>& rows) override;
  /// Gives a table without a header its names, one per column, and its rates, as another file has them.
  void describe(std::vector<std::string> names, std::vector<StatedRate> rates);

 private:
  template <class Visit>
  void visit_lines(const Visit& visit) const;
  char find_separator() const;
  void read_preamble(std::optional<int> skip_lines);
  bool read_names(std::string_view line, std::string_view above);
  bool is_row_with_words(const std::vector<std::string_view>& cells) const;
  void read_header(std::string_view line, std::string_view above, std::vector<std::string>& commented);
  void check_columns(std::size_t count) const;
  bool begins_another(std::string_view line) const;
  [[noreturn]] void refuse_sections(std::string_view line, std::size_t line_number) const;
  bool is_cut(std::string_view line) const;
  bool read_units(const std::vector<std::string_view>& cells);
  void check_row(const std::vector<std::string_view>& cells, std::size_t line_number) const;
  void keep_blank_lines();
  void add_row(std::string_view line, const std::vector<std::string_view>& cells);
  void index_cells(const std::vector<std::string_view>& cells);
  std::string_view cell(std::size_t row, std::size_t column) const;
  Commas commas_in(int column) const;
  void add_nanoseconds(int column, std::vector<double>& seconds) const;
  bool has_points_beside(int column) const;
  double finite(const Parsed& parsed, std::string_view cell, int column, std::size_t row, Missing missing) const;
  std::size_t line_of(std::size_t row) const;
  std::string how_to_leave_out() const;
  std::string remedy_for_text(std::size_t row) const;

  /// A cell's place in its row.
  struct Place {
    std::uint32_t begin, length;
  };

  std::string text_, where_;
  bool is_sheet_ = false;
  bool ends_in_line_ = false;  ///< the text lacks a line end at its end
  std::size_t cut_line_ = 0;
  Warnings warnings_;
  Preamble preamble_;
  char separator_;
  bool is_plain_ = false;  ///< is_plain() of the text and its separator
  bool has_header_ = false;
  int header_lines_ = 0;          ///< lines of names and units outside the preamble
  std::string_view header_line_;  ///< the line of names, if it is outside the preamble
  std::vector<std::string> names_;
  std::vector<std::string_view> rows_;
  std::vector<Place> cells_;  ///< of rows that are not plain, row by row: a search for each would read a wide row whole
};

}  // namespace decid::recording
