// Which recordings the arguments of a command name: files, folders, and patterns that the shell has left alone.
#pragma once

#include <set>
#include <string>
#include <vector>

namespace decid::tools {

/// What folders and patterns hold besides recordings.
struct LeftOut {
  std::size_t dead_links = 0;     ///< links that lead to no file
  std::size_t other_endings = 0;  ///< files that do not end like a recording's
  std::size_t descriptions = 0;   ///< participants.tsv, README.txt and the like
  std::size_t folders = 0;        ///< folders within a folder, if they are not read too
  std::set<std::string> endings;  ///< of the files of other endings: ".pdf"

  /// Returns a line for people, empty if nothing is left out.
  std::string text() const;
};

struct RecordingFiles {
  std::vector<std::string> files;
  LeftOut left_out;
};

/// Returns the files that the arguments stand for.
/// - A folder: every file in it whose name ends like a recording's (.csv, .tsv, .txt, .dat, .mat, .c3d, .xlsx, .trc,
///   .mot, in capitals too), in the order of their names; with `recursive` also the files in the folders within, except
///   hidden ones. Files that describe recordings are left out: participants.tsv, README.txt, *_channels.tsv and others
///   of BIDS.
/// - A pattern of *, ? and [] that is no file itself: what it matches, in order, folders likewise. "**" stands for any
///   number of folders; what it matches must end like a recording's if it is the last part.
/// - Anything else: itself, whether it is there or not.
/// Folders and patterns leave out `others`: what else the call reads or writes.
/// Throws Error for a folder without a recording, one that cannot be read, a pattern that matches nothing, and standard
/// input ("-") that is named twice.
RecordingFiles recording_files(const std::vector<std::string>& arguments, const std::vector<std::string>& others,
                               bool recursive = false);

}  // namespace decid::tools
