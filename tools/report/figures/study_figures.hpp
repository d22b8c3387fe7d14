// The figures of `decid study`: each as SVG, drawn here and nowhere else - the page shows the same drawing -, and as a
// table of its numbers.
#pragma once

#include <string>
#include <vector>

#include "identify/studies/study.hpp"

namespace decid::tools {

struct Figure {
  std::string id;  ///< its files are id.svg and id.csv
  std::string title, caption;
  std::string svg, csv;
};

/// In the paper's order, then what the estimate is worth. Those whose data the study lacks are left out.
std::vector<Figure> study_figures(const Study& study);

}  // namespace decid::tools
