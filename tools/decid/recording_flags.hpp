// The options of commands that read recordings, and their errors for those that cannot be used.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "identify/recordings.hpp"
#include "tools/decid/command.hpp"

namespace decid::tools {

/// What --mass and --height say.
struct BodyFlags {
  std::optional<double> mass_kg, height_m;

  /// The subject's, if they were given. Throws Error if one stands alone.
  std::optional<sim::Body> body() const;
};
/// --mass and --height.
void add_body_options(const Command& command, BodyFlags& flags);

/// The options themselves.
struct RecordingFlags : BodyFlags {
  std::vector<std::string> files;
  std::string column, unit, truth, tilt_column, tilt_unit, invert, detrend = "none";
  std::string leg, trunk, hip, shoulder, ankle, section, trial;
  bool recursive = false;
  std::optional<double> rate, begin, com_height;
  std::optional<int> skip_lines;
  double fill_gaps = 0.0;
  std::optional<double> missing;

  std::vector<RecordingSource> sources;  ///< of the files, once they are found

  /// Replaces `files` by what they stand for (recording_files.hpp), except `others`. Says on standard error what is
  /// left out, unless `quiet`.
  void find_files(const std::vector<std::string>& others, bool quiet);
  /// Finds the recordings that the files hold, as find_files(); `files` are their names then.
  void find_sources(const std::vector<std::string>& others, bool quiet);
  /// The files of the recordings, each once.
  std::vector<std::string> distinct_files() const;
  /// Throws Error for options that contradict each other.
  ReadOptions read_options() const;
  /// Those of --truth, if it was given. Throws Error for others than the table's.
  std::optional<sim::Parameters> known(const sim::ParameterTable& table) const;
};
/// How recordings are read: all options that their errors and warnings advise.
void add_reading_options(const Command& command, RecordingFlags& flags);
inline constexpr const char* reading_options[] = {
    "--column", "--unit",        "--com-height", "--leg",    "--trunk",  "--hip",     "--shoulder",
    "--ankle",  "--skip-lines",  "--section",    "--trial",  "--rate",   "--missing", "--fill-gaps",
    "--begin",  "--tilt-column", "--tilt-unit",  "--invert", "--detrend"};
/// The recordings themselves, which need not be given, and those options.
Option add_recording_flags(const Command& command, RecordingFlags& flags);
/// --truth, of the commands that show estimates.
void add_truth_option(const Command& command, RecordingFlags& flags);

/// Throws the error of a single recording; several are kept, each with its own.
void refuse_alone(const std::vector<RecordingResult>& all);
/// To be called when all is written: prints a line on standard error for each that could not be used, then throws
/// Error if there is one.
void tell_errors(const std::string& command, const std::vector<RecordingResult>& all);

}  // namespace decid::tools
