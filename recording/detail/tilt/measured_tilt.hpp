// A recorded tilt of the platform, from a CSV file. Not installed.
// Columns, units and times are found as in recordings (recording/recording.hpp).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "recording/recording.hpp"

namespace decid::recording {

struct TiltFile {
  std::filesystem::path path;
  std::string column = {};        ///< name or number from 1; empty: tilt, platform, a_fs or similar, or the only column
  std::optional<Unit> unit = {};  ///< empty: from the column's name (..._deg, ..._rad), else Error
  std::optional<double> rate_hz = {};  ///< replaces the time column, which must not contradict it
  bool is_cycle = false;               ///< the first sample follows the last: the protocol has several cycles
};

/// Returns the tilt in degrees at sample_rate_hz. Resamples a tilt of another rate: a cycle periodically, another tilt
/// with its ends reflected (resample.hpp: Ends).
/// Throws Error for a file that cannot be read, for ambiguous columns, units or rates, for cells that are not numbers,
/// and for more samples than a protocol may have. Throws Error for a given rate that differs by more than 1% from the
/// rate of even times. Throws Error for a cycle whose ends do not join (sim::broken_joint) or whose length is more than
/// 0.05 samples from a whole number. Errors name the settings as a protocol does ("measured.column").
/// Adds to `warnings`, if not null, what was left out of the file or changed in its samples.
std::vector<double> read_tilt_deg(const TiltFile& file, double sample_rate_hz, Warnings* warnings = nullptr);

}  // namespace decid::recording
