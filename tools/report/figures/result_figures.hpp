// The figures of identified or fitted recordings, for a paper: each as SVG 1.1, whose text stays text, and as CSV.
#pragma once

#include <array>
#include <vector>

#include "identify/result.hpp"
#include "tools/report/figures/svg.hpp"

namespace decid::tools {

/// Names of all figures that result_figures() can return.
inline constexpr std::array result_figure_ids{"estimates", "sessions", "conditions", "responses", "controllers"};

/// Returns the figures of the recordings that can be used:
/// - "estimates": a panel per parameter; a dot per recording with its 90% interval, in its group, and the mean of the
///   group's people;
/// - "sessions", "conditions", if there are two or more: a panel per parameter; a line per person through the means of
///   the person's recordings;
/// - "responses": gain and phase of sway to tilt by group, the median of the recordings and their middle half. It has
///   the recordings of the first recording's protocol, and is omitted if they have no frequency response;
/// - "controllers", if several were fitted: a row per recording, a column per controller; gain and phase of the
///   recorded response over the 90% band of the controller's simulated trials. The drawing has the first 12 recordings.
/// Parameters that a fit fixes have no panel. Groups, people, sessions and conditions come from the study's sheet, else
/// from the table of groups.
std::vector<Figure> result_figures(const Report& report);

}  // namespace decid::tools
