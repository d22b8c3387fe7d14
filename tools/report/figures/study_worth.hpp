// Figures of the accuracy of an estimate, for study_figures.hpp.
#pragma once

#include <vector>

#include "tools/report/figures/study_figures.hpp"

namespace decid::tools {

/// The minimum number of trials of a bin in a figure; the table has the smaller bins too.
inline constexpr int fewest_trials_drawn = 10;

/// Error against sway and against noise at each level of measurement noise, and the learning curve if there is one.
void add_worth_figures(const ModelStudy& study, std::vector<Figure>& figures);

}  // namespace decid::tools
