// A table of recorded signals from any kind of file: named columns of numbers.
// Not installed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "recording/recording.hpp"
#include "recording/stated_rate.hpp"

namespace decid::recording {

/// Limits of a file, so that a wrong one ends in an Error and not in all of the memory.
inline constexpr std::size_t max_rows = 10'000'000, max_columns = 1000;

/// What to do with cells that say that there is no value: empty, nan, NA, null, -. `fillable` refuses them too, and
/// names the option that fills them.
enum class Missing { refused, fillable, kept };
/// What to do about a cell that was refused.
const char* remedy_for(Missing missing);

/// The values of a column that tells recordings apart, and which one each row has, by its place in `values`. An empty
/// value is none.
struct RowLabels {
  std::vector<std::string> values;
  std::vector<std::uint32_t> of_row;
};

/// An array of a file, each element of which may be a recording: "trials", 3.
struct TableArray {
  std::string name;
  std::size_t elements;
  bool is_matrix = false;  ///< its columns are the elements, which may be signals of one recording as well
};

class Table {
 public:
  Table() = default;
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;
  virtual ~Table() = default;

  int columns() const { return static_cast<int>(names().size()); }
  /// Values in a column; those of a MAT-file need not be equally long.
  virtual std::size_t rows(int column) const = 0;
  /// The names are the file's own, and can be relied on.
  virtual bool has_header() const = 0;
  virtual const std::vector<std::string>& names() const = 0;
  /// A column's name without the structures that hold it ("time" of "trials(2).time"), and its whole path. After
  /// choose(), a column that belongs to another recording has no name of its own.
  virtual const std::string& own_name(int column) const { return names()[static_cast<std::size_t>(column)]; }
  virtual const std::string& path(int column) const { return names()[static_cast<std::size_t>(column)]; }
  /// The numbers of a column. Throws Error with the place of the first cell that is not a finite number; missing ones
  /// become NaN where they are kept.
  virtual std::vector<double> numbers(int column, Missing missing = Missing::refused) const = 0;
  /// Those of a column of time, whose cells may also be clock times where the file is text.
  virtual std::vector<double> times(int column) const { return numbers(column); }
  /// Where a row stands in the file, for people: "line 12", "row 11".
  virtual std::string place_of(std::size_t row) const = 0;
  /// The sample rates that the file states beside its columns (a MAT-file's variable fs, lines above a text's table,
  /// parameters of a C3D file).
  virtual const std::vector<StatedRate>& stated_rates() const = 0;
  /// The unit of angles that the file states for all its columns whose names have none (inDegrees of OpenSim).
  virtual std::optional<Unit> unit() const { return {}; }
  /// The format itself samples all columns evenly, at a rate that the file states: no column is the time.
  virtual bool is_even() const { return false; }
  /// What was done to a column's samples, a sentence; empty: nothing.
  virtual std::string change_of(int) const { return {}; }
  /// Lines of the file above the table, which are not read.
  virtual std::size_t preamble_lines() const { return 0; }
  /// What was left out of the file, for people.
  virtual const Warnings& warnings() const { return none_; }

  /// What may hold signals and is not read, for people: "z (20 x 1 complex)".
  virtual std::string unread() const { return {}; }

  /// Says which column is the sway: columns and rates of other structures no longer count. Returns false where there
  /// are no structures.
  virtual bool choose(int) { return false; }
  /// The first column of the matrix that the chosen one is of, which may be its time.
  virtual int first_column() const { return 0; }
  /// Arrays whose elements may be recordings.
  virtual const std::vector<TableArray>& arrays() const;
  /// Drops the columns of the array's other elements; counted from 0.
  virtual void keep_element(const std::string& array, std::size_t element);
  /// What each row has in a column; by default of numbers. Throws Error as numbers().
  virtual RowLabels labels(int column) const;
  /// What the file is, for people, if files of its format hold one recording alone: "C3D file". Otherwise empty.
  virtual std::string format_of_one() const { return {}; }
  /// Keeps these rows, in increasing order, of all columns that are as long as this one.
  virtual void keep_rows(int column, const std::vector<std::size_t>& rows);

 private:
  Warnings none_;
};

/// What stands for a file's name where text comes from standard input.
inline constexpr const char* standard_input = "-";

/// Reads a CSV file (csv.hpp), a MAT-file (mat.hpp), a C3D file (c3d.hpp) or a workbook (xlsx.hpp): by its name's
/// end, .mat or .c3d, or its first bytes; "-" is standard input, which is no MAT-file. `skip_lines`: how many lines of
/// a text stand above its table; empty: they are found. `section`: which of a text's tables, by name or number from 1
/// (sections.hpp); empty: the only one. Throws Error if it cannot be read or holds no numbers.
std::unique_ptr<Table> read_table(const std::filesystem::path& path, std::optional<int> skip_lines = {},
                                  const std::string& section = {});

}  // namespace decid::recording
