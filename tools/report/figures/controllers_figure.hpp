// The figure of several controllers: the recorded frequency response of each recording over the band of each
// controller.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "identify/result.hpp"
#include "tools/report/figures/svg.hpp"

namespace decid::tools {

/// A recording to which several controllers were fitted. It may be not usable: another controller may explain it.
struct ComparedRecording {
  const RecordingResult* recording;
  std::string cells;  ///< of a row of the CSV: participant_id, session, group, condition, file
};

/// Returns the figure "controllers" (result_figures.hpp); empty if no recording has a response.
std::vector<Figure> controllers_figure(const Report& report, std::span<const ComparedRecording> recordings);

}  // namespace decid::tools
