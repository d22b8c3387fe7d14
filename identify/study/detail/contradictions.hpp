// Contradictions of a study's sheet, lines about a person that cannot be right together, and copies among the
// recordings of a plan. Not installed.
#pragma once

#include "identify/study/recording_plan.hpp"

namespace decid {

/// The remedy for lines without a participant.
inline constexpr const char* repeat_the_name =
    "repeat the name in each line of the person; of merged cells only the first holds it";

/// Throws Error if two lines put one person in two groups. Letter case does not count.
void refuse_two_groups(const StudySheet& sheet);

/// Throws Error if a sheet spells a person in two ways, who would count as two: 01 and 1, S-2 and S2, sub-S3 and S3.
/// Letter case does not count.
void refuse_two_spellings(const StudySheet& sheet);

/// Adds warnings to the recordings of participants who have two bodies (`two_bodies`) or two ages (`two_ages`) in one
/// session, or without sessions. Between sessions both may change. Markers of one column at two heights are two bodies,
/// too. A column of body mass indices that is more than 15% off weight and height is a warning (`other_bmi`); rounding
/// changes it less, and an index outside of 10 to 70 kg/m2 is a mark or a class. An empty cell contradicts nothing, and
/// neither does a body that is partly of another line.
void warn_of_contradictions(RecordingPlan& plan);

/// Adds a warning (`same_content`) to recordings whose files hold the same bytes, and which are read with the same
/// options: a group or a joint fit would count the copy as another person or as new evidence. Reads only files of equal
/// size, and neither pipes nor standard input.
void warn_of_copies(RecordingPlan& plan);

}  // namespace decid
