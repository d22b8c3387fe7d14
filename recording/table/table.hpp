// Tables of recorded signals from any kind of file: named columns of numbers.
// Not installed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "recording/detail/stated_rate.hpp"
#include "recording/recording.hpp"

namespace decid::recording {

/// Limits of a file, so that a wrong file causes an Error instead of filling the memory.
inline constexpr std::size_t max_rows = 10'000'000, max_columns = 1000;

/// The treatment of cells that mark a missing value: empty, nan, NA, null, -.
enum class Missing { refused, kept };
/// The remedy for a refused cell.
inline constexpr char remedy_for_missing[] = "write a number there";

/// The values of a column that distinguishes recordings, and the index into `values` of each row. An empty value
/// belongs to no recording.
struct RowLabels {
  std::vector<std::string> values;
  std::vector<std::uint32_t> of_row;
};

/// An array of a file whose elements may be recordings: "trials", 3.
struct TableArray {
  std::string name;
  std::size_t elements;
  bool is_matrix = false;  ///< its columns are the elements; they may also be signals of one recording
};

class Table {
 public:
  Table() = default;
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;
  virtual ~Table() = default;

  int columns() const { return static_cast<int>(names().size()); }
  /// Returns the number of values in a column; columns of a MAT-file may differ in length.
  virtual std::size_t rows(int column) const = 0;
  /// Returns true if the names are the file's own and reliable.
  virtual bool has_header() const = 0;
  virtual const std::vector<std::string>& names() const = 0;
  const std::string& name(int column) const { return names()[static_cast<std::size_t>(column)]; }
  /// Returns a column's name without the structures that hold it ("time" for "trials(2).time"). After choose(), a
  /// column of another recording has no own name.
  virtual const std::string& own_name(int column) const { return name(column); }
  virtual const std::string& path(int column) const { return name(column); }
  /// Returns the numbers of a column. Throws Error with the place of the first cell that is not a finite number.
  /// Missing values become NaN if they are kept.
  virtual std::vector<double> numbers(int column, Missing missing = Missing::refused) const = 0;
  /// Returns the numbers of each step-th row, from the first on. Cells of other rows need not be numbers.
  virtual std::vector<double> numbers_of_each(int column, std::size_t step, Missing missing) const;
  /// Returns the numbers of a time column, whose cells may also be clock times in a text file.
  virtual std::vector<double> times(int column) const { return numbers(column); }
  /// Returns a row's place in the file, for messages: "line 12", "row 11".
  virtual std::string locate(std::size_t row) const = 0;
  /// Returns the sample rates that the file states outside of its columns (a MAT-file's variable fs, lines above a
  /// text's table, parameters of a C3D file).
  virtual const std::vector<StatedRate>& stated_rates() const = 0;
  /// Returns the unit of angles that the file states for all columns without a unit in their names (inDegrees of
  /// OpenSim).
  virtual std::optional<Unit> unit() const { return {}; }
  /// Returns true if the format samples all columns evenly, at a stated rate: no column is the time.
  virtual bool is_even() const { return false; }
  /// Describes a change of a column's samples in a sentence; empty: unchanged.
  virtual std::string change_at(int) const { return {}; }
  /// Returns the number of ignored lines above the table.
  virtual std::size_t preamble_lines() const { return 0; }
  /// Returns warnings about ignored parts of the file.
  virtual const Warnings& warnings() const { return none_; }
  /// Returns the number of the last line if the file ends in the middle of it, so that it is no row; else 0.
  virtual std::size_t cut_line() const { return 0; }

  /// Returns unread content that may hold signals, for messages: "z (20 x 1 complex)".
  virtual std::string unread() const { return {}; }

  /// Chooses the sway column: columns and rates of other structures no longer count. Returns false where there are no
  /// structures.
  virtual bool choose(int) { return false; }
  /// Returns the first column of the chosen column's matrix, which may be its time.
  virtual int first_column() const { return 0; }
  /// Returns arrays whose elements may be recordings.
  virtual const std::vector<TableArray>& arrays() const;
  /// Drops the columns of the array's other elements; counted from 0.
  virtual void keep_element(const std::string& /*array*/, std::size_t /*element*/) {}
  /// Returns the labels of the rows in a column; by default of numbers. Throws Error as numbers().
  virtual RowLabels labels(int column) const;
  /// Returns the text of a cell, where a table has texts; else empty.
  virtual std::string label(int, std::size_t) const { return {}; }
  /// Returns the format's name for messages, "C3D file", if its files hold only one recording. Otherwise empty.
  virtual std::string format_of_one() const { return {}; }
  /// Keeps these rows, in increasing order, of all columns as long as this one.
  virtual void keep_rows(int /*column*/, const std::vector<std::size_t>& /*rows*/) {}

 protected:
  /// Returns a kept row's number in the file.
  std::size_t row_of_file(std::size_t row) const { return row < kept_.size() ? kept_[row] : row; }
  void number_kept_rows(const std::vector<std::size_t>& rows);

 private:
  Warnings none_;
  std::vector<std::size_t> kept_;  ///< rows of the file; empty: all
};

/// Throws Error if the file ends in the middle of its last line. For tables whose every row counts.
void require_whole(const Table& table, const std::string& where);

/// The file name that stands for standard input.
inline constexpr const char* standard_input = "-";

/// Reads a CSV file (csv.hpp), a MAT-file (mat.hpp), a C3D file (c3d.hpp) or a workbook (xlsx.hpp), recognised by its
/// extension, .mat or .c3d, or its first bytes. "-" is standard input, which cannot be a MAT-file. `skip_lines`: the
/// number of a text's lines above its table; empty: decid finds it. `section`: one of a text's tables, by name or
/// number from 1 (sections.hpp); empty: the only one. Throws Error if the file cannot be read or holds no numbers.
std::unique_ptr<Table> read_table(const std::filesystem::path& path, std::optional<int> skip_lines = {},
                                  const std::string& section = {});

}  // namespace decid::recording
