// A figure as a drawing and as a table of its numbers.
#pragma once

#include <string>

namespace decid::tools {

struct Figure {
  std::string id;  ///< its files are id.svg and id.csv
  std::string title, caption;
  std::string svg, csv;
};

}  // namespace decid::tools
