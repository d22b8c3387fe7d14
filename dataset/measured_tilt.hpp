// A recorded tilt of the platform, from a CSV file. Private to dataset.
// Columns, units and times are found as in recordings (dataset/recording.hpp).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/recording.hpp"

namespace decid::dataset {

struct TiltFile {
  std::filesystem::path path;
  std::string column = {};        ///< name or number from 1; empty: tilt, platform, a_fs or the like, or the only one
  std::optional<Unit> unit = {};  ///< empty: from the column's name (..._deg, ..._rad), else Error
  std::optional<double> rate_hz = {};  ///< overrides the time column
};

/// The tilt in degrees at sample_rate_hz, resampled if it was recorded at another rate. Throws Error for a file that
/// cannot be read, columns, units or rates that are not clear, cells that are no numbers, and more samples than a
/// protocol may have. Errors name the settings as a protocol does ("measured.column").
std::vector<double> read_tilt_deg(const TiltFile& file, double sample_rate_hz);

}  // namespace decid::dataset
