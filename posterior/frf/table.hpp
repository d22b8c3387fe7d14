// A frequency response as people publish it: gain and phase of the body's sway to the platform's tilt at some ten
// frequencies, with or without confidence, in a CSV or MAT-file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/fft.hpp"

namespace decid::frf {

struct Row {
  double frequency_hz = 0.0;
  sim::Complex response;   ///< sway over tilt, rad/rad; a positive phase leads
  double deviation = 0.0;  ///< standard deviation of its real part, and of its imaginary part; 0: not known
  int harmonics = 0;       ///< of the stimulus, that were averaged; 0: not known
};

struct Table {
  std::string file;
  std::vector<Row> rows;   ///< by frequency
  std::string confidence;  ///< the column that it is from: "sd"; empty: there is none

  bool has_confidence() const { return !confidence.empty(); }
};

/// The fewest rows: a controller has more unknowns than two frequencies have numbers.
inline constexpr int fewest_rows = 3;

/// Columns, in any order and case, with a unit behind the name or below it; others may hold anything:
///   frequency (freq, f)    in Hz
///   gain (magnitude)       sway over tilt
///   phase                  in degrees, or in radians if its name says so: phase_rad
/// and at most one kind of confidence, s being the standard deviation of either part of the complex response:
///   sd (se, sem, gain_sd)  s: of the gain, as it was measured or as the mean of a group is known
///   ci95 (gain_ci95)       half the width of the gain's 95 % interval, 1.96 s
///   radius95 (radius)      radius of the 95 % circle in the complex plane, 2.448 s
///   coherence, cycles      s = gain sqrt((1 - coherence) / (2 coherence cycles harmonics)); the coherence of single
///                          cycles, squared as usual (Bendat and Piersol, Random Data, 4th ed. 2010, ch. 9)
///   harmonics              optional: how many neighbouring harmonics of the stimulus a row is the mean of
///
/// Throws Error for: no file, no header, a column that is missing or there twice, two kinds of confidence, a cell that
/// is not a finite number, fewer than fewest_rows rows or more than 1000, frequencies that are not above 0, not in
/// rising order or there twice, gains and confidences that are not above 0, a coherence outside of 0 to 1, cycles and
/// harmonics that are not whole numbers, a gain in decibels, and phases that look like radians but are not called so.
Table read_table(const std::filesystem::path& path);

}  // namespace decid::frf
