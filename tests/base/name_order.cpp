// The order of names that contain numbers.
#include "base/name_order.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

using decid::NameOrder;
using Names = std::vector<std::string>;

TEST_CASE("NameOrder: numbers by value, all else as text") {
  for (const Names& ordered :
       {Names{"1", "2", "10"}, Names{"ses-1", "ses-2", "ses-10"}, Names{"T1", "T2", "T10", "T10b", "T11"},
        Names{"month 0", "month 3", "month 6", "month 12"}, Names{"0", "3 months", "12 months"},
        Names{"-3", "-1", "0", "3"}, Names{"day -10", "day -2", "day 0", "day 1"},
        Names{"0.25", "0,5", "1", "1.25", "1.5"}, Names{"2.9.2024", "10.9.2024"}, Names{"2024-09-02", "2024-10-01"},
        Names{"patients, 2", "patients, 10", "patients, baseline"}, Names{"", "01", "1", "1a", "A", "B", "a", "b"},
        Names{"99999999999999999998", "99999999999999999999"}}) {
    Names sorted(ordered.rbegin(), ordered.rend());
    std::ranges::sort(sorted, NameOrder());
    CHECK(sorted == ordered);
  }
  // A strict weak order: every triple is consistent.
  const Names names{"", "-1", "-0", "0", "-a", ".", "1", "01", "1.0", "1.", "-1.5x", "-2", "a-1", "a -1", "a1", "a"};
  const NameOrder less;
  for (const std::string& a : names)
    for (const std::string& b : names) {
      CHECK((less(a, b) || less(b, a)) == (a != b));
      for (const std::string& c : names)
        if (less(a, b) && less(b, c)) CHECK(less(a, c));
    }
}
