// MAT-files of version 7.3, which are HDF5 files: read by matio (https://github.com/tbeu/matio) in a child process,
// because neither library withstands malicious files. Not installed.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "recording/formats/detail/mat/mat_variable.hpp"

namespace decid::recording {

/// Returns all variables. Variables without real numbers have no values. `file_bytes`: the file's size. Throws Error if
/// it cannot be read.
std::vector<MatVariable> read_mat_73(const std::filesystem::path& path, std::size_t file_bytes);

/// Convert the child's answer from variables to bytes and back. The reader checks everything: it returns nothing unless
/// the bytes are exactly a list of variables.
std::string to_bytes(const std::vector<MatVariable>& variables);
bool from_bytes(std::string_view bytes, std::vector<MatVariable>& variables);

}  // namespace decid::recording
