// MAT-files of versions 4 to 7, read from memory.
// Format: The MathWorks, MAT-File Format (version 5, and its chapter on version 4); 7 is 5 with parts in zlib's format.
// Not installed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "recording/formats/detail/mat/mat_variable.hpp"

namespace decid::recording {

enum class MatVersion { none, v4, v5, v73 };
/// Returns true if the first four bytes, which must be present, are the first number of a version 4 file.
bool is_mat_4(std::string_view bytes);
/// Returns the version by the header of 128 bytes, or by the first number of version 4, which has no header.
MatVersion mat_version(std::string_view bytes);

/// Returns all variables of a file of version 4, and of versions 5 to 7. Variables without real numbers have no values.
/// Throws Error for a file that is cut short or damaged, or larger than any recording after decompression. `where`
/// names the file.
std::vector<MatVariable> read_mat_4(std::string_view bytes, const std::string& where);
std::vector<MatVariable> read_mat_5(std::string_view bytes, const std::string& where);

}  // namespace decid::recording
