// The figures of `decid study`: each as SVG, drawn here and nowhere else - the page shows the same drawing -, and as a
// table of its numbers.
#pragma once

#include <vector>

#include "identify/evaluation/model_study.hpp"
#include "tools/report/figures/figure.hpp"

namespace decid::tools {

/// Returns the paper's figures in its order, then the figures about accuracy. It omits figures whose data the study
/// lacks.
std::vector<Figure> study_figures(const ModelStudy& study);

}  // namespace decid::tools
