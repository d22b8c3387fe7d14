// Finds the recordings that a command's arguments name: files, folders, and patterns that the shell did not expand.
#pragma once

#include <set>
#include <string>
#include <vector>

namespace decid::tools {

/// The other contents of folders and patterns, which are not recordings.
struct LeftOut {
  std::size_t dead_links = 0;     ///< links that lead to no file
  std::size_t other_endings = 0;  ///< files whose name does not end like a recording's
  std::size_t descriptions = 0;   ///< participants.tsv, README.txt and the like
  std::size_t results = 0;        ///< tables that decid wrote (is_table_of_results())
  std::size_t folders = 0;        ///< folders within a folder, if they are not read too
  std::set<std::string> endings;  ///< endings of the other files: ".pdf"

  /// Returns a line for people, empty if nothing is left out.
  std::string text() const;
};

struct RecordingFiles {
  std::vector<std::string> files;
  LeftOut left_out;
};

/// Returns the files for which the arguments stand.
/// - A folder: every file in it whose name ends like a recording's (.csv, .tsv, .txt, .dat, .mat, .c3d, .xlsx, .trc,
///   .mot, .sto, .lvm, in capitals too), in the order of their names. With `recursive` also the files in the folders
///   within, except hidden ones. Omits tables of decid's results, and files that describe recordings: participants.tsv,
///   README.txt,
///   *_channels.tsv and others of BIDS.
/// - A pattern of *, ? and [] that is not a file itself: its matches in order, and the files of folders among them.
///   "**" stands for any number of folders; if it is the last part, its matches must end like a recording's name.
/// - Anything else: the argument itself, even if no such file exists.
/// Folders and patterns omit `others`, which are no recordings of the call.
/// Throws Error for a folder without a recording, an unreadable folder, a pattern without a match, and standard input
/// ("-") that is named twice.
RecordingFiles recording_files(const std::vector<std::string>& arguments, const std::vector<std::string>& others,
                               bool recursive = false);

}  // namespace decid::tools
