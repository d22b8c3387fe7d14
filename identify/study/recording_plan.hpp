// The recordings of a call, with the person, the options and the protocol of each: all alike, or by a study's sheet.
//
//   const StudySheet sheet = read_sheet("participants.tsv");
//   const RecordingPlan plan = make_plan(sheet, make_sources(recordings_below("."), {}), Choice::by_sheet, {});
//   Report report = identify_plan(model, "my model", plan);      // study_results.hpp
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/warning.hpp"
#include "identify/recordings.hpp"
#include "identify/study/sheet.hpp"

namespace decid {

/// A body and a protocol that recordings share.
struct RecordingSetting {
  std::optional<sim::Body> body;  ///< empty: the protocol's is assumed
  std::string protocol;           ///< a name or a file; empty: the call's
  bool operator==(const RecordingSetting&) const = default;
};

struct PlannedRecording {
  RecordingSource source;
  ReadOptions reading;
  std::size_t setting = 0;  ///< place in RecordingPlan::settings
  SheetEntry entry = {};
  std::optional<double> mass_kg = {}, height_m = {};              ///< of the person, by the sheet
  bool is_body_of_other_line = false;                             ///< mass or height: `body_of_other_line`
  std::optional<Error> error = {};                                ///< why the recording cannot be used
  std::vector<std::pair<std::string, std::string>> options = {};  ///< of reading, by the sheet
  Warnings warnings = {};  ///< contradictions of the sheet, bodies of other lines, and copies
  std::string line = {};   ///< of the sheet: "participants.tsv, line 3"; empty: none
};

struct RecordingPlan {
  std::vector<RecordingSetting> settings;
  std::vector<PlannedRecording> recordings;
  std::optional<StudySheet> sheet = {};
  /// The sheet's notes, and lines that are of none of the recordings, for people.
  std::vector<std::string> notes = {};
  std::vector<std::size_t> unused = {};  ///< for_groups: places in the sheet of these lines
  /// Numbers of lines with a file and without a participant, if other lines have one; empty for_groups. Their
  /// recordings have an error.
  std::vector<std::size_t> nameless = {};
};

/// Plans recordings that have the same options and the same body, reading.body. Copies of one file have warnings.
RecordingPlan make_plan(const std::vector<RecordingSource>& sources, const ReadOptions& reading);

/// The choice of the recordings: those of the call, or those that the sheet's lines name among the files near it.
/// for_groups: those of the call, for a table that only names their groups. Its lines may name other files, its folder
/// counts in paths, a person may be in two groups, and recordings have no warnings.
enum class Choice { by_call, by_sheet, for_groups };

/// Plans the recordings of a sheet. A line with a file is of the recordings whose path ends with it (path_match.hpp);
/// of several, by_call, the line with the most folders counts, then the one in the recording's letter case and ending.
/// A line without one is of all recordings whose path names its participant, and its session if it has one. Both lines
/// count for a recording; its own comes first, then `reading` and reading.body. Paths in the sheet are relative to its
/// folder. If no line has a session, the session is LABEL of "ses-LABEL" in the path (PathKey). A weight or height that
/// both lack is that of another line of the person (`body_of_other_line`), before reading.body. The sheet is no
/// recording. These recordings have an error: one of the call without a line; a line whose file is missing; a person
/// without a recording, by_sheet; a recording with two lines, or with two people or sessions, and a line with two
/// recordings, that are equally alike; a line without a participant, if others have one; a wrong cell; and one without
/// the other of mass and height. Recordings of a person with two bodies or two ages in one session have warnings, and
/// so have copies of one file. Throws Error for a person in two groups, and for two spellings of one (01 and 1).
RecordingPlan make_plan(StudySheet sheet, const std::vector<RecordingSource>& sources, Choice choice,
                        const ReadOptions& reading);

/// Throws Error if two of the recordings are one, also through another path or a link: the same file, trial and, by the
/// sheet, section, columns and begin. `option`: what reads each once, for the message. A sheet's lines that name one
/// again have an error already.
void refuse_repeated(const RecordingPlan& plan, const std::string& option);

}  // namespace decid
