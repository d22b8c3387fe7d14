// MAT-files of version 7.3, which are HDF5 files: read by matio (https://github.com/tbeu/matio) in a process of its
// own, because neither it nor HDF5 promises to survive a file that was made to break them. Not installed.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "recording/formats/mat/mat_variable.hpp"

namespace decid::recording {

/// All variables. Those that hold no real numbers have no values. file_bytes: the file's size. Throws Error if it
/// cannot be read.
std::vector<MatVariable> read_mat_73(const std::filesystem::path& path, std::size_t file_bytes);

/// What that process answers: variables as bytes, and back. The reader takes nothing for granted: returns nothing if
/// the bytes are not variables, whole and no more.
std::string to_bytes(const std::vector<MatVariable>& variables);
bool from_bytes(std::string_view bytes, std::vector<MatVariable>& variables);

}  // namespace decid::recording
