// Recordings of sway in a CSV, MAT, C3D or .xlsx file: with or without a header, at any rate, from any start, with or
// without the platform's tilt. trial.hpp brings them to a protocol's rate and length.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/sample_range.hpp"
#include "base/warning.hpp"
#include "recording/signals.hpp"

namespace decid::recording {

/// The longest gap that the program interpolates, in seconds: longer gaps would invent half a trial.
inline constexpr double longest_gap_s = 60.0;

enum class Unit { degree, radian, milliradian };

struct RecordingOptions {
  std::string column = {};                   ///< name of the sway column, or its number from 1; empty: found by name
  std::optional<Unit> unit = {};             ///< empty: from the column's name (..._deg, _rad, _mrad), else degrees
  std::optional<double> rate_hz = {};        ///< overrides the time column; 1 to 100,000
  std::optional<double> missing_value = {};  ///< a number that marks missing values, in addition to the known ones
  bool mean_is_upright = false;              ///< an offset will be subtracted (TrialOptions): sizes count from the mean
  double fill_gaps_s = 0.0;                  ///< longest gap to interpolate; 0: gaps are errors
  std::string tilt_column = {};              ///< the platform's tilt, by name or number from 1; empty: see find_tilt
  bool find_tilt = true;  ///< a column clearly named as the tilt is read without being named in the options
  std::optional<Unit> tilt_unit = {};  ///< empty: from the column's name, else `unit`, else degrees
  bool invert_sway = false;            ///< positive against the protocol's direction of tilt
  bool invert_tilt = false;
  /// Lines of a text file above its table; empty: found.
  std::optional<int> skip_lines = {};
  std::string section = {};  ///< one of a text file's tables, by name or number from 1; empty: the only one
  /// The divider of several recordings in a file: a column, several joined by commas, or an array of a MAT-file.
  /// `trial`: the recording to read, one of list_trials().
  std::string trial_column = {}, trial = {};
  bool is_one_trial = false;  ///< all rows are one recording, even if a column called trial or similar changes
  /// Sources of the sway instead of `column` (columns by name or number from 1; read_sway.hpp has the formulas):
  std::optional<double> com_height_m = {};            ///< `column` is a position, at this height above the ankles
  std::string leg_column = {}, trunk_column = {};     ///< angles in space of leg and trunk
  std::string hip_column = {}, shoulder_column = {};  ///< positions along the tilt's direction; need body_height_m
  std::string ankle_column = {};                      ///< the origin of positions; empty: their means are upright
  std::optional<double> body_height_m = {};    ///< of the person, for hip and shoulder, and to check com_height_m
  std::optional<double> metres_per_unit = {};  ///< of positions; empty: from the column's name (..._mm, _cm, _m)
};

/// A numeric column that may be the platform's tilt.
struct OtherColumn {
  std::string name;
  bool has_unit = false;  ///< a unit of angle, in its name or in its file
  /// Returns its values in rad; without a unit they count as degrees. Throws Error for words, and for hardly any
  /// values.
  std::function<std::vector<double>()> rad;
  std::vector<double> coarse_rad = {};  ///< each coarse_step-th of its values, about 10 Hz; empty: only all are known
  std::size_t coarse_step = 1;
};

struct Recording {
  std::string file;  ///< empty: from samples in memory
  double rate_hz = 0.0;
  std::string rate_advice;    ///< the remedy for a wrong rate; empty: only another recording helps
  Signals<double> signals;    ///< com_sway, and platform_tilt if requested
  double first_time_s = 0.0;  ///< the first sample's time by the file's time column; 0 without one
  /// Columns that may be the platform's tilt if no column is the tilt by its name: the protocol shows whether one is.
  std::vector<OtherColumn> other_columns;
  /// The recordings of the other axes of the same centre of mass: bring_to_protocol() chooses the axis that follows the
  /// tilt.
  std::vector<Recording> other_axes;
  std::string axis_problem;            ///< names further axes that cannot be read, and why; empty: none
  std::string tilt_problem;            ///< a caution if none of other_columns is the tilt; empty: none
  std::vector<SampleRange> tilt_gaps;  ///< samples of the tilt that were missing and bridged, ascending
  bool is_large = false;               ///< the sway is larger than a standing body's; a warning says so
  /// By its name or its values, and not named by the user: if it does not follow the protocol, the trial is not usable.
  bool tilt_was_found = false;
  bool tilt_was_found_by_values = false;  ///< and a warning names its column
  bool tilt_size_is_unknown = false;      ///< the tilt's column has no unit and was scaled to the protocol's size
  std::string change;                   ///< describes a column that may tell recordings of the file apart; empty: none
  std::optional<double> change_s = {};  ///< after which the column has its second value, if it may be a trigger
  std::vector<SampleRange> gaps;        ///< samples of the sway that were missing and filled, ascending
  Warnings warnings;                    ///< assumptions, and suspicious data
};

/// Reads a recording from a file:
/// - a CSV file;
/// - a MAT-file of version 4, 5, 7 or 7.3: variables, fields, elements of arrays; matrix columns by number;
/// - a C3D file: columns "LASI_x (mm)" of its points, and its analog channels;
/// - the first sheet of a workbook (.xlsx), as text. "-" is standard input.
///
/// Recognises in CSV: the separator (comma, semicolon, tab, blanks), a decimal comma, the header, a line of units,
/// comment lines (#, %), lines above the table, and a last line that is cut short. Text may be UTF-8, UTF-16 or
/// Windows-1252.
///
/// The time is the first column called time, t, timestamp, Zeit or similar, in seconds unless its name ends in ms or
/// us, or as clock times. In a file without a header it is the first of several columns if it increases evenly. The
/// sway is the column named in the options, else the first called com_sway, COM_x, sway or similar (_deg, _rad and
/// _mrad may follow), else the only column except time and tilt. A column called tilt, platform, Plattform or similar
/// is read as the platform's tilt; a warning says so.
///
/// If a centre of mass has several axes ("COM_x", "COM_y"), the first is read, and the others into other_axes. Rows
/// that equal the row before them, time included, are dropped, with a note.
///
/// The rate is that of the mean time step. Without a time, a MAT-file's scalar fs or similar or a C3D file's own rate
/// counts. Uneven times (clock.hpp) are interpolated to an even grid, with a warning. Lost samples and missing cells
/// (empty, nan) are gaps, which are filled by straight lines up to fill_gaps_s, with a warning.
///
/// Throws Error for:
/// - a missing or empty file, no sway column or an ambiguous one (two of one name are), and a sway whose name excludes
/// an angle (a length, a velocity, an ankle's);
/// - a cell of time, sway or tilt that is not a finite number, with its line (other columns may hold anything), and
/// rows of different length;
/// - several recordings without trial_column: a column called trial, block, subject or similar changes, or times start
/// again;
/// - a gap that must not be filled, times that go back or jump without a given rate, and a rate outside of 1 to 100,000
/// Hz;
/// - fewer than 2 samples, more than 10 million, more than 1000 columns, a constant signal, and sway beyond 90 degrees.
/// Warns if the unit is assumed or looks wrong (peak beyond 20 degrees, or peak to peak under 0.1 degrees; without a
/// unit also peak to peak beyond 20 degrees, or a standard deviation beyond 5), and if a given rate contradicts the
/// time.
Recording read_recording(const std::filesystem::path& path, const RecordingOptions& options);

/// Returns the names of a file's recordings by options.trial_column, in the order in which they begin: the values of
/// the column ("2", "s01,2"), or the numbers of an array's elements from 1. Throws Error for the file as read_recording
/// does, for a missing column, and for a column that does not distinguish recordings.
std::vector<std::string> list_trials(const std::filesystem::path& path, const RecordingOptions& options);

/// Makes a recording from samples in memory, rad. mean_is_upright: as of RecordingOptions. Throws Error for fewer than
/// 2 samples, a sample that is not finite, a constant signal, sway beyond 90 degrees, and a rate outside of 1 to
/// 100,000 Hz. Warns of implausible sizes as read_recording does.
Recording make_recording(std::span<const double> sway_rad, double rate_hz, bool mean_is_upright = false);

}  // namespace decid::recording
