// The cells of a study's sheet that go with a recording to its results.
#pragma once

#include <string>
#include <vector>

namespace decid {

struct SheetEntry {
  std::string participant, session, group, condition;
  std::vector<std::string> cells = {};  ///< of the sheet's other columns, in their order; empty: n/a
  bool operator==(const SheetEntry&) const = default;
};

}  // namespace decid
