// Numbers whose digits are in groups of three: "1,234.5", "1.234,5", "1'234". Some are read one way only; "1,234" is
// 1.234 in one file and 1234 in another, which the rest of its column tells.
// Not installed.
#pragma once

#include <optional>
#include <string_view>

namespace decid::recording {

/// The number, if its digits are in groups of three between `group`: "1,234", "1,234.5", "1,234,567". Its first group
/// does not begin with 0, so "0,123" is none.
std::optional<double> grouped(std::string_view cell, char group);
/// True if such a number can only be read so: it has two groups, or a decimal sign too.
bool is_plainly_grouped(std::string_view cell);

/// The meaning of commas in the cells of a column; none: there are no cells with one.
enum class Commas { none, decimal, thousands, unclear };

/// Finds it from the cells of a column, one after the other.
class CommaFinder {
 public:
  /// Returns true once it is plain: other cells need not be looked at.
  bool see(std::string_view cell);
  /// `point_elsewhere`: other columns have decimal points. `commas_separate`: cells, so that those with commas are
  /// quoted.
  Commas found(bool point_elsewhere, bool commas_separate) const;
  /// A cell that may be read in two ways, if there is one.
  std::string_view example() const { return example_; }

 private:
  std::optional<Commas> plain_;
  bool other_numbers_ = false;  ///< without a comma, which are not 0: who writes 1,000 for 1.000 writes 2,000 too
  std::string_view example_;
};

/// True for "0.25", which has a decimal point; "1.234" may be a thousand.
bool has_decimal_point(std::string_view cell);

}  // namespace decid::recording
