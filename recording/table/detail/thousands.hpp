// Numbers whose digits are in groups of three: "1,234.5", "1.234,5", "1'234". Some have only one reading; "1,234" is
// 1.234 in one file and 1234 in another, which the rest of its column decides. Not installed.
#pragma once

#include <optional>
#include <string_view>

namespace decid::recording {

/// Returns the number, if its digits are in groups of three between `group`: "1,234", "1,234.5", "1,234,567". Its first
/// group must not begin with 0, so "0,123" does not count.
std::optional<double> grouped(std::string_view cell, char group);
/// Returns true if such a number has only one reading: it has two groups, or a decimal sign too.
bool is_plainly_grouped(std::string_view cell);

/// The meaning of commas in the cells of a column; none: no cell has one.
enum class Commas { none, decimal, thousands, unclear };

/// Finds the meaning from a column's cells in order.
class CommaFinder {
 public:
  /// Returns true once the meaning is clear: no further cells are needed.
  bool see(std::string_view cell);
  /// `point_elsewhere`: other columns have decimal points. `commas_separate`: commas separate cells, so that cells with
  /// commas are quoted.
  Commas found(bool point_elsewhere, bool commas_separate) const;
  /// Returns an ambiguous cell, if there is one.
  std::string_view example() const { return example_; }

 private:
  std::optional<Commas> plain_;
  bool other_numbers_ = false;  ///< without a comma, and not 0: a program that writes 1,000 for 1.000 also writes 2,000
  std::string_view example_;
};

/// Returns true for "0.25", which has a decimal point; "1.234" may be a thousand.
bool has_decimal_point(std::string_view cell);

}  // namespace decid::recording
