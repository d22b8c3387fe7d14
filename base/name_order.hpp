// The order of names that contain numbers: "month 3" before "month 12".
#pragma once

#include <string_view>

namespace decid {

/// Orders names as text, with numbers in them by value: 0.25, 0.5, 2, 10; ses-1, ses-10. A hyphen at the beginning, or
/// after a blank, is a number's sign. Different names of equal value (1, 01) are ordered as text.
struct NameOrder {
  using is_transparent = void;
  bool operator()(std::string_view a, std::string_view b) const;
};

}  // namespace decid
