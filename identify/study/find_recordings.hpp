// Finds files that may be recordings, by their names and, of text, their first lines.
#pragma once

#include <array>
#include <filesystem>
#include <string_view>
#include <vector>

namespace decid {

/// The endings of recordings' names.
inline constexpr std::array<std::string_view, 11> endings_of_recordings{".csv",  ".tsv", ".txt", ".dat", ".mat", ".c3d",
                                                                        ".xlsx", ".trc", ".mot", ".sto", ".lvm"};

/// Returns true for names that begin with a point, and for the lock files of office programs ("~$results.xlsx").
bool is_hidden(const std::filesystem::path& path);

/// Returns true for names with one of these endings, in capitals too.
bool has_ending_of_recordings(const std::filesystem::path& path);

/// Returns true for files that stand beside recordings in data sets (BIDS 1.9): participants.tsv, README.txt,
/// *_channels.tsv and the like.
bool is_description(const std::filesystem::path& path);

/// Returns true for decid's own results: a table of `--table` or `--long`, as CSV or .xlsx, and the CSV of `--draws`
/// and
/// `--figures`.
bool is_table_of_results(const std::filesystem::path& path);

/// Returns the files in a folder and in the folders within that may be recordings, in the order of their names. Omits
/// hidden files and folders, descriptions, and tables of results. Empty for a folder that cannot be read. folder: empty
/// for the current one.
std::vector<std::filesystem::path> recordings_below(const std::filesystem::path& folder);

}  // namespace decid
