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
  std::string column = {};        ///< name or number from 1; empty: tilt, platform, a_fs or the like, or the only one
  std::optional<Unit> unit = {};  ///< empty: from the column's name (..._deg, ..._rad), else Error
  std::optional<double> rate_hz = {};  ///< instead of the time column, which it must not contradict
  bool is_cycle = false;               ///< its first sample follows its last: the protocol has several cycles
};

/// The tilt in degrees at sample_rate_hz, resampled if it was recorded at another rate: a cycle as one that goes round,
/// another tilt with its ends reflected (resample.hpp: Ends). Throws Error for a file that cannot be read, columns,
/// units or rates that are not clear, a rate given that differs by more than 1% from that of even times, cells that are
/// not numbers, more samples than a protocol may have, and a cycle whose ends do not join (sim::broken_joint) or whose
/// length misses a whole number of samples by more than 0.05. Errors name the settings as a protocol does
/// ("measured.column"). Adds to `warnings`, if it is not null, what was left out of the file or changed in its samples.
std::vector<double> read_tilt_deg(const TiltFile& file, double sample_rate_hz, Warnings* warnings = nullptr);

}  // namespace decid::recording
