// Copies among the recordings of a plan. Not installed.
#pragma once

#include "identify/study/recording_plan.hpp"

namespace decid {

/// Adds a warning (`same_content`) to recordings whose files hold the same bytes, and which are read with the same
/// options: a group or a joint fit would count the copy as another person or as new evidence. Reads only files of equal
/// size, and neither pipes nor standard input.
void warn_of_copies(RecordingPlan& plan);

}  // namespace decid
