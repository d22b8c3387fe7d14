// Signals that a table holds in rows of their own, as logs of several sensors or topics do: each row has the time of
// one of them, and the cells of the others are empty. Not installed.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "recording/detail/clock.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// The signals of a table that the sway's rows lack, by their columns.
class SeparateRows {
 public:
  /// Returns a column's numbers in each step-th row, NaN where they are missing.
  using Read = std::function<std::vector<double>(int column, std::size_t step)>;

  /// Keeps of `table` the rows in which the columns `sway` have numbers, if nearly each other row has one of a column
  /// that is empty in the sway's rows, changes and has times of its own, and the sway lacks a number in a twentieth of
  /// the rows or more. Otherwise changes nothing. `time`: the column of the times. Throws Error, naming `file`, if the
  /// sway's columns have values in different rows.
  SeparateRows(Table& table, const std::vector<int>& sway, int time, const Read& read, const std::string& file);

  bool has(int column) const { return signals_.contains(column); }
  std::size_t rows() const { return rows_; }  ///< that were not kept; 0: nothing changed

  /// Returns a column at `samples` times of the clock's grid, by straight lines between its own values; NaN where they
  /// are more than 0.1 s and 2.5 of their median steps apart. Its end values last so long, too.
  std::vector<double> at(int column, const Clock& clock, std::size_t samples) const;

 private:
  struct Signal {
    std::vector<double> time, value;
  };
  std::map<int, Signal> signals_;
  std::size_t rows_ = 0;
};

}  // namespace decid::recording
