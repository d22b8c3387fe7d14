// MAT-files of versions 4 to 7, read from memory.
// Format: The MathWorks, MAT-File Format (version 5, and its chapter on version 4); 7 is 5 with parts in zlib's format.
// Not installed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "recording/formats/mat/mat_variable.hpp"

namespace decid::recording {

enum class MatVersion { none, v4, v5, v73 };
/// Returns true if the first four bytes, which must be there, are the first number of a version 4's.
bool is_mat_4(std::string_view bytes);
/// By the header of 128 bytes, or by the first number of a version 4's, which has none.
MatVersion mat_version(std::string_view bytes);

/// All variables of a file of version 4, and of 5 to 7. Those that hold no real numbers have no values. Throws Error
/// for a file that is cut short or damaged, and one that is larger inflated than any recording: `where` names it.
std::vector<MatVariable> read_mat_4(std::string_view bytes, const std::string& where);
std::vector<MatVariable> read_mat_5(std::string_view bytes, const std::string& where);

}  // namespace decid::recording
