// Recordings of BIDS' motion extension: NAME_motion.tsv has no header; NAME_channels.tsv names its columns, and
// NAME_motion.json gives their rate. Not installed. Format: BIDS 1.9, Motion.
#pragma once

#include <filesystem>
#include <vector>

#include "recording/formats/csv.hpp"

namespace decid::recording {

/// Returns true for NAME_motion.tsv.
bool is_motion_bids(const std::filesystem::path& path);

/// Describes such a file's table by the files beside it. Names are the channels' with their units; the channel of type
/// LATENCY is the time; the rate is SamplingFrequency. The files beside it may stand in folders above, with fewer
/// entities in their names (the inheritance principle). Leaves a file with a header of its own, or without channels, as
/// it is. Throws Error for channels that do not match the columns, and for damaged files beside it.
void read_motion_bids(const std::filesystem::path& path, CsvTable& table);

/// Returns the files beside such a recording that read_motion_bids() reads; none for other recordings.
std::vector<std::filesystem::path> files_beside(const std::filesystem::path& path);

}  // namespace decid::recording
