// The figures of `decid study`: each as SVG, drawn here and nowhere else - the page shows the same drawing -, and as a
// table of its numbers.
#pragma once

#include <vector>

#include "identify/evaluation/model_study.hpp"
#include "tools/report/figures/svg.hpp"

namespace decid::tools {

/// Returns the paper's figures in its order, then the figures about accuracy. It omits figures whose data the study
/// lacks.
std::vector<Figure> study_figures(const ModelStudy& study);

/// The minimum number of trials of a bin in a figure; the table has the smaller bins too.
inline constexpr int min_trials_drawn = 10;
/// Adds error against sway and against noise at each level of measurement noise, and the learning curve if there is
/// one.
void add_worth_figures(const ModelStudy& study, std::vector<Figure>& figures);

}  // namespace decid::tools
