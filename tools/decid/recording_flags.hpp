// The options of commands that read recordings, and their errors for those that cannot be used.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "identify/study/recording_plan.hpp"
#include "tools/decid/command.hpp"

namespace decid::tools {

/// The values of --mass and --height.
struct BodyFlags {
  std::optional<double> mass_kg, height_m;

  /// Returns the person's body, if both values were given. Throws Error if only one was given.
  std::optional<sim::Body> body() const;
  /// Throws Error if both values were given although the body of the protocol is not a person's, but such as a robot's.
  void refuse_instead_of(const sim::Protocol& protocol) const;
};
/// Adds --mass and --height.
void add_body_options(const Command& command, BodyFlags& flags);

/// The values of the options.
struct RecordingFlags : BodyFlags {
  std::vector<std::string> files;
  std::string column, unit, truth, tilt_column, tilt_unit, invert, detrend = "none";
  std::string leg, trunk, hip, shoulder, ankle, section, trial, study;
  bool recursive = false;
  std::optional<double> rate, begin, com_height;
  std::optional<int> skip_lines;
  double fill_gaps = 0.0;
  std::optional<double> missing;

  std::vector<RecordingSource> sources;  ///< the recordings in the files, once they are found
  std::vector<std::string> named;        ///< the files of the call, each once, without those that a sheet names

  /// Finds the recordings in the files for which `files` stand (recording_files.hpp), except `inputs`, the other files
  /// that the call reads; `files` are then their names. An output that has a recording's name stays among them, so that
  /// Outputs::check() refuses to overwrite a recording. With --study and no file it finds all recordings below the
  /// sheet's folder. Prints on standard error which files it left out, unless `quiet`.
  void find_sources(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs, bool quiet);
  /// Returns the plan of the recordings found, by the sheet of --study if there is one. `sources` and `files` are then
  /// the plan's. Prints on standard error which lines are of no recording, unless `quiet`.
  RecordingPlan plan(const ReadOptions& reading, bool quiet);
  /// Returns the files of the recordings, each once.
  std::vector<std::string> distinct_files() const;
  /// Throws Error for options that contradict each other.
  ReadOptions read_options() const;
  /// Returns the parameters of --truth, if it was given. Throws Error for parameters that are not in the table.
  std::optional<sim::Parameters> known(const sim::ParameterTable& table) const;
};
/// Adds the options that control how recordings are read: all that errors and warnings of reading advise.
void add_reading_options(const Command& command, RecordingFlags& flags);
inline constexpr const char* reading_options[] = {
    "--column", "--unit",        "--com-height", "--leg",    "--trunk",  "--hip",     "--shoulder",
    "--ankle",  "--skip-lines",  "--section",    "--trial",  "--rate",   "--missing", "--fill-gaps",
    "--begin",  "--tilt-column", "--tilt-unit",  "--invert", "--detrend"};
/// Adds the argument for the recordings, which is optional, and the reading options.
Option add_recording_flags(const Command& command, RecordingFlags& flags);
/// Adds --study, an option of the commands that read many recordings.
void add_study_option(const Command& command, RecordingFlags& flags);
/// Adds --truth, an option of the commands that show estimates.
void add_truth_option(const Command& command, RecordingFlags& flags);

/// Prints a line on standard error for each recording that could not be used, then throws Error if there is one. Call
/// it after all output is written.
void tell_errors(const std::string& command, const std::vector<RecordingResult>& all);

}  // namespace decid::tools
