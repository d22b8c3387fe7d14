// Text of C: names, literals, comments, tables.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace decid::tools {

/// Returns true for "stdint" and so on, in any case.
bool is_c_header(const std::string& name);
/// Throws Error unless `name` is an identifier of C, at most 40 characters long, and no header of C.
void check_firmware_name(const std::string& name);
/// Replaces DECID_FW in `text`: by `name` before names in lower case, by NAME elsewhere.
std::string with_name(std::string text, const std::string& name);
/// Replaces the first `what` in `text`, which must contain it.
std::string replaced(std::string text, const std::string& what, const std::string& by);
std::string define(const std::string& name, long long value);
std::string define_double(const std::string& name, double value);
/// Returns a C literal with exactly these bits. Throws Error for a value that is not finite.
std::string literal(float value);
std::string literal(double value, int digits = 17);
/// Returns the bits of each value.
std::vector<std::uint32_t> to_bits(const std::vector<float>& values);
/// Returns `text` as a string literal of C.
std::string quoted(const std::string& text);
/// Escapes `text` for a C comment.
std::string comment(const std::string& text);
/// Returns a C table, several values per line.
template <class T>
std::string table(const std::string& declaration, const std::vector<T>& values);

}  // namespace decid::tools
