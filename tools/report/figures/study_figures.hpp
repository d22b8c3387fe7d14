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

/// Returns the paper's figures in its order, then the figures about accuracy. It omits figures whose data the study
/// lacks.
std::vector<Figure> study_figures(const Study& study);

}  // namespace decid::tools
