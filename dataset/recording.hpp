// Recordings as people have them: sway in a CSV file or a MAT-file, with or without a header, at any rate, from any
// start, with or without the platform's tilt; brought to a model's sample rate and length.
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
  double fill_gaps_s = 0.0;            ///< missing values and lost samples up to this long are interpolated
  std::string tilt_column = {};        ///< the platform's tilt, by name or number from 1; empty: not read
  std::optional<Unit> tilt_unit = {};  ///< as `unit`
  bool invert_sway = false;            ///< it was measured positive against the protocol's direction of tilt
  bool invert_tilt = false;
};

struct Recording {
  std::string file;
  std::string column;       ///< what was read: "COM_x", or "column 2"
  std::string tilt_column;  ///< likewise; empty: none
  double rate_hz = 0.0;
  std::vector<double> sway_rad;
  std::vector<double> tilt_rad;       ///< as long as the sway, or empty
  std::vector<std::string> warnings;  ///< for people: what was assumed, what looks odd
};

/// Reads a CSV file, or a MAT-file of version 4, 5, 7 or 7.3 (variables or fields of a struct; a matrix's columns by
/// number). CSV: separator (comma, semicolon, tab, blanks), decimal comma, header, a line of units and comment lines
/// (#, %) are recognised.
/// The time is the column called time, t, timestamp, Zeit or the like, in seconds unless its name ends in ms or us; in
/// a file without a header, the first of several columns if it increases evenly. The sway is the column named in the
/// options, else the first called com_sway, COM_x, sway or the like (_deg and _rad may follow), else the only column
/// beside the time. The rate is that of the time's mean step, or, without a time, a MAT-file's scalar fs or the like.
/// Times that are uneven by up to 30% of a step are interpolated to an even grid, with a warning; lost samples and
/// missing cells (empty, nan) are gaps, filled by straight lines up to fill_gaps_s, with a warning.
///
/// Throws Error for: no file, empty, no or ambiguous sway column, a cell of time, sway or tilt that is not a finite
/// number (with its line; other columns may hold anything), a gap that is not to be filled, rows of different length,
/// times that go back or jump and no rate given, fewer than 2 samples, more than 10 million, more than 1000 columns, a
/// constant signal, sway beyond 90 degrees. Warns if the unit had to be assumed, if it looks wrong (peak beyond 20
/// degrees, or peak to peak under 0.001 degrees), and if a rate given contradicts the time.
Recording read_recording(const std::filesystem::path& path, const RecordingOptions& options);

/// What the resampling's filter sees beyond a signal's ends.
enum class Ends {
  held,       ///< the last value: for noise, where any other continuation would show the end's noise again
  reflected,  ///< the signal turned about its last sample, 2 x(0) - x(-t): for movements. A slope goes on instead of
              ///< stopping, which halves the velocity at the end; a rest stays one; the last sample keeps its value
};

/// Windowed-sinc resampling: a low-pass of linear phase and no delay, Kaiser window, 52 samples of the lower rate long.
/// Pass band to 0.40 of the lower rate within 0.1%, -6 dB at 0.45, stop band from 0.50 at -70 dB and below. Any ratio.
/// Equal rates copy. The result has floor(duration * to) samples, the first at the time of the signal's first.
std::vector<double> resample(const std::vector<double>& signal, double from_hz, double to_hz, Ends ends = Ends::held);
/// The same filter on one cycle of a periodic signal: its first sample follows its last. `count` samples, the first at
/// the signal's first, divide the cycle evenly.
std::vector<double> resample_cycle(const std::vector<double>& signal, std::size_t count);
/// The same filter, ends held: `count` samples, the first at `start_s` after the signal's first, which need not be a
/// sample's time. Filters also at equal rates.
std::vector<double> resample(const std::vector<double>& signal, double from_hz, double to_hz, double start_s,
                             std::size_t count);

/// What is taken off a trial. `offset`: its mean. `linear`: a straight line too. Both are those of the protocol's whole
/// cycles, about whose mean simulated trials swing. The line's slope is that of the cycles' means: the response to the
/// stimulus is the same in each cycle and leaves it alone; with one cycle it is the line of least squares.
enum class Detrend { none, offset, linear };

struct TrialOptions {
  std::optional<double> start_s = {};  ///< where in the recording the protocol starts; empty: at its first sample, or
                                       ///< where the tilt says
  Detrend detrend = Detrend::none;
};

/// How the tilt measured lies over the tilt that the protocol prescribes.
struct TiltMatch {
  double delay_s = 0.0;          ///< the protocol starts so long after the recording's first sample
  double correlation = 0.0;      ///< over the trial, at that delay
  double gain = 0.0;             ///< measured over prescribed tilt, by least squares
  std::vector<double> tilt_rad;  ///< measured, at the trial's samples
};

/// A recording brought to a protocol.
struct Trial {
  std::vector<float> sway_rad;    ///< the protocol's samples
  std::optional<TiltMatch> tilt;  ///< if the recording has one
};

/// The recording at the protocol's rate (resampled if the rates differ by more than 0.01%) and length.
/// A longer recording is cut: from start_s, or from where its tilt follows the protocol's best, else from its first
/// sample, with a warning that says what was left out. One that lacks up to 1% of the trial at either end is
/// continued by its mirror image, with a warning: that keeps its noise, where holding a value would show as silence.
/// At equal rates a start is rounded to a sample: filtering would change the noise that a model has learned.
/// Throws Error if more is missing, naming both lengths and rates, how many whole cycles there are and how to get a
/// model for them: none are made up, since what changes from cycle to cycle is what the noise is read from. Throws too
/// if start_s is not within the recording, or a tilt does not follow the protocol (correlation below 0.5) or follows it
/// with the other sign. Warns for a correlation below 0.95 and a gain that is off by more than 10%.
Trial fit_to_protocol(Recording& recording, const sim::Protocol& protocol, const TrialOptions& options = {});

}  // namespace decid::dataset
