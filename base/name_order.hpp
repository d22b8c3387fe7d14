// The order of names that contain numbers: "month 3" before "month 12".
#pragma once

#include <string_view>

namespace decid {

/// Orders names as text, with numbers in them by value: 0.25, 0.5, 2, 10; ses-1, ses-10. A hyphen at the beginning, or
/// after a blank, is a number's sign. Dates are ordered by year, month and day: 2024-03-31, 31.3.2024, 31.03.24, and
/// 31/3/2024 or 31-3-2024; with slashes or hyphens the second number is the day if it cannot be a month. Different
/// names of equal value (1, 01) are ordered as text.
struct NameOrder {
  using is_transparent = void;
  bool operator()(std::string_view a, std::string_view b) const;
};

/// Returns true for names of equal value in this order: 1 and 01, 2024-03-05 and 5.3.2024.
bool are_equal_in_order(std::string_view a, std::string_view b);

/// The order of day and month in a date between slashes or hyphens whose year comes last. unclear: both may be months.
enum class DayMonth { none, day_first, month_first, unclear };
/// Returns the order in a name that is such a date; none for any other name, and if day and month are equal.
DayMonth day_month_of(std::string_view name);

}  // namespace decid
