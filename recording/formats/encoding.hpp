// The encodings in which programs save tables, brought to UTF-8. Not installed.
#pragma once

#include <string>

namespace decid::recording {

/// The text in UTF-8, without a byte order mark. UTF-16 is known by its mark, or by a null in every other one of the
/// first bytes; what is not UTF-8 is read as Windows-1252, of which ISO 8859-1 is a part. `where` names the file.
/// Throws Error for bytes that are no text.
std::string to_utf8(std::string bytes, const std::string& where);

}  // namespace decid::recording
