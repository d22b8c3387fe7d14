// Recordings as people have them: sway in a CSV file, with or without a header, brought to a model's sample rate.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/protocol.hpp"

namespace decid::dataset {

enum class Unit { degree, radian };

struct RecordingOptions {
  std::string column = {};             ///< name of the sway column, or its number from 1; empty: found by name
  std::optional<Unit> unit = {};       ///< empty: taken from the column's name (..._deg, ..._rad), else degrees
  std::optional<double> rate_hz = {};  ///< overrides the time column
};

struct Recording {
  std::string file;
  std::string column;  ///< what was read: "COM_x", or "column 2"
  double rate_hz = 0.0;
  std::vector<double> sway_rad;
  std::vector<std::string> warnings;  ///< for people: what was assumed, what looks odd
};

/// Reads a CSV file. Separator (comma, semicolon, tab, blanks), header and comment lines (#, %) are recognised.
/// The time is the column called time, t, timestamp, Zeit or the like, in seconds unless its name ends in ms or us; in
/// a file without a header, the first of several columns if it increases evenly. The sway is the column named in the
/// options, else the first called com_sway, COM_x, sway or the like (_deg and _rad may follow), else the only column
/// beside the time. The rate is that of the time's mean step, all steps being within 1% of their median.
///
/// Throws Error for: no file, empty, no or ambiguous sway column, a cell of time or sway that is not a finite number
/// (with its line; other columns may hold anything), rows of different length, a time that does not increase evenly and
/// no rate given, fewer than 2 samples, more than 10 million, more than 1000 columns, a constant signal, sway beyond 90
/// degrees. Warns if the unit had to be assumed, if it looks wrong (peak beyond 20 degrees, or peak to peak under 0.001
/// degrees), and if a rate given contradicts the time.
Recording read_recording(const std::filesystem::path& path, const RecordingOptions& options);

/// Windowed-sinc resampling with the filter's cut-off at 0.45 of the lower rate (Kaiser window, 80 dB, from 0.40 to
/// 0.50); the signal's ends are held. Equal rates copy. The result has floor(duration * to) samples, the first at the
/// time of the signal's first.
std::vector<double> resample(const std::vector<double>& signal, double from_hz, double to_hz);

/// The recording at the protocol's rate (resampled if the rates differ by more than 0.01%) and length. Up to one second
/// too long: the end is cut, with a warning.
/// Otherwise throws Error naming both lengths and rates, and how to get a model for the recording's protocol.
std::vector<float> fit_to_protocol(Recording& recording, const sim::Protocol& protocol);

}  // namespace decid::dataset
