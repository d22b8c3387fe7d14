// The order of names that contain numbers.
#include "base/name_order.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

using decid::NameOrder;
using Names = std::vector<std::string>;

TEST_CASE("NameOrder: numbers by value, all else as text") {
  for (const Names& ordered : {Names{"1", "2", "10"},
                               Names{"ses-1", "ses-2", "ses-10"},
                               Names{"T1", "T2", "T10", "T10b", "T11"},
                               Names{"month 0", "month 3", "month 6", "month 12"},
                               Names{"0", "3 months", "12 months"},
                               Names{"-3", "-1", "0", "3"},
                               Names{"day -10", "day -2", "day 0", "day 1"},
                               Names{"0.25", "0,5", "1", "1.25", "1.5"},
                               Names{"2.9.2024", "10.9.2024"},
                               Names{"2024-09-02", "2024-10-01"},
                               Names{"10.01.2023", "09.02.2023", "1.3.2023"},
                               Names{"31.12.22", "10.01.23", "09.02.23", "01.03.2023"},
                               Names{"2023-01-10", "09.02.2023", "2023-03-01"},
                               Names{"10/01/2023", "09/02/2023", "13/02/2023"},
                               Names{"01/13/2023", "01/14/2023", "09/02/2023"},
                               Names{"10-01-2023", "09-02-2023"},
                               Names{"patients, 10.01.2023", "patients, 09.02.2023"},
                               Names{"ses-10-01-2023", "ses-09-02-2023"},
                               Names{"1.2.9", "1.2.10", "2.1.1"},
                               Names{"1.10.2.2024", "2.1.1.2023"},
                               Names{"32.01.2023", "40.01.2022"},
                               Names{"patients, 2", "patients, 10", "patients, baseline"},
                               Names{"", "01", "1", "1a", "A", "B", "a", "b"},
                               Names{"99999999999999999998", "99999999999999999999"}}) {
    Names sorted(ordered.rbegin(), ordered.rend());
    std::ranges::sort(sorted, NameOrder());
    CHECK(sorted == ordered);
  }
  // A strict weak order: every triple is consistent.
  const Names names{"10.01.2023",  "2023-01-10", "13/01/2023", "01/13/2023", "01.01.23", "2023",
                    "-10.01.2023", "",           "-1",         "-0",         "0",        "-a",
                    ".",           "1",          "01",         "1.0",        "1.",       "-1.5x",
                    "-2",          "a-1",        "a -1",       "a1",         "a"};
  const NameOrder less;
  for (const std::string& a : names)
    for (const std::string& b : names) {
      CHECK((less(a, b) || less(b, a)) == (a != b));
      for (const std::string& c : names)
        if (less(a, b) && less(b, c)) CHECK(less(a, c));
    }
}

TEST_CASE("day_month_of: only dates between slashes or hyphens whose year comes last may be unclear") {
  using decid::day_month_of, decid::DayMonth;
  CHECK(day_month_of("3/4/2024") == DayMonth::unclear);
  CHECK(day_month_of("12-01-2024") == DayMonth::unclear);
  CHECK(day_month_of("13/4/2024") == DayMonth::day_first);
  CHECK(day_month_of("4/13/2024") == DayMonth::month_first);
  for (const char* name : {"", "3/4/24", "3/4", "4/4/2024", "3.4.2024", "2024-04-03", "13/13/2024", "0/4/2024",
                           "a3/4/2024", "3/4/2024 b", "3/4-2024"})
    CHECK(day_month_of(name) == DayMonth::none);
}
