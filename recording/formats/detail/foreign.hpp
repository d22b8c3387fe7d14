// Recognises files of programs that are neither text nor MAT or C3D files, by their first bytes. Not installed.
#pragma once

#include <string>
#include <string_view>

namespace decid::recording {

/// Throws Error if the bytes are not a table. The error names the file's format and a remedy. `where` names the file;
/// `end` is its extension in lower case: ".xls".
void refuse_foreign(std::string_view bytes, const std::string& where, std::string_view end);

}  // namespace decid::recording
