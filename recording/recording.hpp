// Recordings as people have them: sway in a CSV, MAT, C3D or .xlsx file, with or without a header, at any rate, from
// any start, with or without the platform's tilt. trial.hpp brings them to a protocol's rate and length.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/warning.hpp"
#include "recording/signals.hpp"

namespace decid::recording {

/// The longest gap that the program interpolates, in seconds: half a trial would be made up.
inline constexpr double longest_gap_s = 60.0;

enum class Unit { degree, radian, milliradian };

struct RecordingOptions {
  std::string column = {};             ///< name of the sway column, or its number from 1; empty: found by name
  std::optional<Unit> unit = {};       ///< empty: taken from the column's name (..._deg, _rad, _mrad), else degrees
  std::optional<double> rate_hz = {};  ///< overrides the time column; 1 to 100,000
  std::optional<double> missing_value = {};  ///< a number that stands for a missing value, besides those that are known
  bool mean_is_upright = false;              ///< an offset will be subtracted (TrialOptions): sizes count from the mean
  double fill_gaps_s = 0.0;                  ///< missing values and lost samples up to this long are interpolated
  std::string tilt_column = {};              ///< the platform's tilt, by name or number from 1; empty: see find_tilt
  bool find_tilt = true;               ///< a column that is plainly the tilt by its name is read without being named
  std::optional<Unit> tilt_unit = {};  ///< as `unit`
  bool invert_sway = false;            ///< it is positive against the protocol's direction of tilt
  bool invert_tilt = false;
  /// Lines of a text file above its table; empty: found.
  std::optional<int> skip_lines = {};
  std::string section = {};  ///< which of a text file's tables, by name or number from 1; empty: the only one
  /// What tells several recordings of a file apart: a column, several with commas between them, or an array of a
  /// MAT-file; and which of them is read, one of trials_of().
  std::string trial_column = {}, trial = {};
  bool is_one_trial = false;  ///< all rows are one recording, though a column called trial or the like changes
  /// In place of `column`, the sway comes from (columns by name or number from 1; sway_source.hpp has the formulas):
  std::optional<double> com_height_m = {};            ///< `column` is a position, at this height above the ankles
  std::string leg_column = {}, trunk_column = {};     ///< angles in space of leg and trunk
  std::string hip_column = {}, shoulder_column = {};  ///< positions along the tilt's direction; need body_height_m
  std::string ankle_column = {};                      ///< that positions count from; empty: their means are upright
  std::optional<double> body_height_m = {};
  std::optional<double> metres_per_unit = {};  ///< of positions; empty: from the column's name (..._mm, _cm, _m)
};

struct Recording {
  std::string file;  ///< empty: from samples in memory
  double rate_hz = 0.0;
  std::string rate_advice;      ///< what to do if the rate is wrong; empty: nothing better than another recording
  Signals<double> signals;      ///< com_sway, and platform_tilt if it was asked for
  bool is_large = false;        ///< its sway is larger than a standing body's; a warning says so
  bool tilt_was_found = false;  ///< by its name alone: if it does not follow the protocol the trial is not usable
  Warnings warnings;            ///< what was assumed, what looks odd
};

/// Reads a CSV file, or a MAT-file of version 4, 5, 7 or 7.3 (variables, fields, elements of arrays; matrix columns by
/// number), or a C3D file (columns "LASI_x (mm)" of its points, and its analog channels), or the first sheet of a
/// workbook (.xlsx), as text. CSV: separator (comma, semicolon, tab, blanks), decimal comma, header, a line of units
/// and comment lines (#, %) are recognised, and lines above the table, and a last line that is cut short; text may be
/// UTF-8, UTF-16 or Windows-1252. "-" is standard input. The time is the first column called time, t, timestamp, Zeit
/// or the like, in seconds unless its name ends in ms or us, or clock times; in a file without a header, the first of
/// several columns if it increases evenly. The sway is the column named in the options, else the first called com_sway,
/// COM_x, sway or the like (_deg, _rad and _mrad may follow), else the only column beside the time. The rate is that of
/// the time's mean step, or, without a time, a MAT-file's scalar fs or the like, or a C3D file's own. Uneven times
/// (clock.hpp) are interpolated to an even grid, with a warning; lost samples and missing cells (empty, nan) are gaps,
/// filled by straight lines up to fill_gaps_s, with a warning. A column called tilt, platform, Plattform or the like is
/// read as the platform's, said in a warning.
///
/// Throws Error for: no file, empty, no or ambiguous sway column (two of one name are), one that is no angle by its
/// name (a length, a velocity, an ankle's), a cell of time, sway or tilt that is not a finite number (with its line;
/// other columns may hold anything), several recordings below each other (a column called trial, block, subject or the
/// like changes, or times start again) without trial_column, a gap that is not to be filled, rows of different length,
/// times that go back or jump and no rate given, a rate outside of 1 to 100,000 Hz, fewer than 2 samples, more than 10
/// million, more than 1000 columns, a constant signal, sway beyond 90 degrees. Warns if the unit had to be assumed, if
/// it looks wrong (peak beyond 20 degrees, or peak to peak under 0.001 degrees), and if a rate given contradicts the
/// time.
Recording read_recording(const std::filesystem::path& path, const RecordingOptions& options);

/// The recordings of a file by options.trial_column, in the order in which they begin: the values of the column ("2",
/// "s01,2"), or the numbers of an array's elements from 1. Throws Error as read_recording does of the file, for a
/// column that there is not, and for one that does not tell recordings apart.
std::vector<std::string> trials_of(const std::filesystem::path& path, const RecordingOptions& options);

/// A recording from samples in memory, rad. Throws Error for fewer than 2 samples, one that is not finite, a constant
/// signal, sway beyond 90 degrees, and a rate outside of 1 to 100,000 Hz. Warns as read_recording does of sizes that no
/// standing body's sway has.
Recording recording_of(std::span<const double> sway_rad, double rate_hz);

}  // namespace decid::recording
