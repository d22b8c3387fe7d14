// A published frequency response: gain and phase of the body's sway to the platform's tilt at some ten frequencies,
// with or without confidence, in a CSV or MAT-file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/fft.hpp"

namespace decid::frf {

struct Row {
  double frequency_hz = 0.0;
  sim::Complex response;   ///< sway over tilt, rad/rad; a positive phase leads
  double stddev = 0.0;     ///< standard deviation of its real part, and of its imaginary part; 0: unknown
  int harmonics = 0;       ///< averaged harmonics of the stimulus; 0: unknown
  double coherence = 0.0;  ///< squared, of single cycles; 0: unknown
};

struct Table {
  std::string file;
  std::vector<Row> rows;   ///< by frequency
  std::string confidence;  ///< the column of the confidence: "sd"; empty: none

  bool has_confidence() const { return !confidence.empty(); }
};

/// The minimum number of rows: a controller has more unknowns than two frequencies have numbers.
inline constexpr int min_table_rows = 3;

/// Reads a table. Columns may have any order and case, with a unit after the name or below it; other columns may hold
/// anything:
///   frequency (freq, f)    in Hz
///   gain (magnitude)       sway over tilt
///   phase                  in degrees, or in radians if its name is phase_rad
/// and at most one kind of confidence, where s is the standard deviation of either part of the complex response:
///   sd (se, sem, gain_sd)  s of the measured gain, or of the mean of a group
///   ci95 (gain_ci95)       half the width of the gain's 95 % interval, 1.96 s
///   radius95 (radius)      radius of the 95 % circle in the complex plane, 2.448 s
///   coherence, cycles      s = gain sqrt((1 - coherence) / (2 coherence cycles harmonics)); the coherence of single
///                          cycles, squared as usual (Bendat and Piersol, Random Data, 4th ed. 2010, ch. 9). 0 and 1
///                          count as rounded: half a unit of the table's last decimal place from there
///   harmonics              optional: the number of neighbouring harmonics of the stimulus that a row averages
///
/// Throws Error for:
/// - no file, no header, a last line that is cut, a missing column, two columns of one quantity, two kinds of
///   confidence, and a cell that is not a finite number;
/// - fewer than min_table_rows rows or more than 1000, and frequencies that are not above 0, not rising or repeated;
/// - gains outside of 1e-6 to 1000, confidences that are not above 0, a coherence outside of 0 to 1, and cycles and
///   harmonics that are not whole numbers;
/// - a unit that a column cannot have, such as decibels and percent, and phases that look like radians without a unit.
Table read_table(const std::filesystem::path& path);

}  // namespace decid::frf
