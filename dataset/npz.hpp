// Data sets on disk: an .npz file, a zip archive of NumPy arrays, as numpy.load opens it.
// Members: sway (trials x samples, float32, rad), parameters (trials x 7, float64), group (int32), split (uint8),
// and decid.json (0-dimensional array of bytes, dtype S): {"format": 1, "seed": .., "protocol": {...},
// "parameters": ["Kp", ...]}.
// Formats: numpy.lib.format version 1.0; archive members are stored, not deflated; their time is fixed, so equal data
// sets are equal files.
#pragma once

#include <filesystem>

#include "dataset/dataset.hpp"

namespace decid::dataset {

/// Writes the file whole or not at all.
void write_npz(const std::filesystem::path& path, const Dataset& data);

/// Throws Error for anything that is not such a file: not a zip, truncated, a member missing, of another type or shape,
/// non-finite values, groups or splits out of range, a protocol that does not fit the number of samples.
Dataset read_npz(const std::filesystem::path& path);

}  // namespace decid::dataset
