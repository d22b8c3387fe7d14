// Tables of numbers as text: separated by commas, semicolons, tabs or blanks, with or without a header line.
// Not installed: for dataset and tools. Format: RFC 4180 and what spreadsheets, MATLAB and NumPy make of it; see CsvTable.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace decid::dataset {

/// A table over its text; numbers are parsed only for the columns asked for, so others may hold anything.
///
/// Taken in stride: UTF-8 byte order mark, line ends \n, \r\n and \r, blank lines, comment lines (# or %), blanks
/// around cells, quoted cells (on one line), a separator at the end of the lines, a decimal comma where the separator
/// is none ("1,5;2,7").
class CsvTable {
 public:
  /// Throws Error if there are no lines of data, rows differ in length, or there are too many rows or columns.
  /// `where` names the file.
  CsvTable(std::string text, std::string where);

  int columns() const { return static_cast<int>(names_.size()); }
  std::size_t rows() const { return rows_; }
  bool has_header() const { return has_header_; }
  /// From the header, else "column 1", "column 2", ...
  const std::vector<std::string>& names() const { return names_; }

  /// The numbers of a column. Throws Error with the line of the first cell that is not a finite number.
  std::vector<double> numbers(int column) const;
  /// The line of the file, from 1, in which a row stands.
  std::size_t line_of(std::size_t row) const;

 private:
  template <class Visit>
  void for_each_line(const Visit& visit) const;
  char find_separator() const;
  void read_header(std::string_view line);
  double number(std::string_view cell, int column, std::size_t line) const;

  std::string text_, where_;
  char separator_;
  bool has_header_ = false;
  std::vector<std::string> names_;
  std::size_t rows_ = 0;
};

}  // namespace decid::dataset
