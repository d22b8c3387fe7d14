// Which recordings the arguments of a command name: files, folders, and patterns that the shell has left alone.
#pragma once

#include <string>
#include <vector>

namespace decid::tools {

/// A folder stands for every file in it whose name ends like a recording's (.csv, .tsv, .txt, .dat, .mat, .c3d, .xlsx,
/// .trc, .mot, in capitals too; hidden files and folders within are left out), in the order of their names; a pattern
/// of *, ? and [] that is no file itself for what it matches, in order, folders likewise. Both leave out `others`: what
/// else the call reads or writes. What else is named stands for itself, whether it is there or not. Throws Error for a
/// folder without a recording, one that cannot be read, and a pattern that matches nothing.
std::vector<std::string> recording_files(const std::vector<std::string>& arguments,
                                         const std::vector<std::string>& others);

}  // namespace decid::tools
