// Converts the encodings in which programs save tables to UTF-8. Not installed.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace decid::recording {

/// Returns the text in UTF-8, without a byte order mark at its start. Recognises UTF-16 by its mark, or by a null in
/// every second one of the first bytes. Reads other bytes that are not UTF-8 as Windows-1252, which contains ISO
/// 8859-1. `where` names the file. Throws Error for bytes that are not text.
std::string to_utf8(std::string bytes, const std::string& where);

/// Appends the character of a code point below 0x110000 in UTF-8.
void append_utf8(std::string& text, std::uint32_t point);

/// Returns UTF-8 with plain blanks for the blanks that spreadsheets and typesetters write (no-break, figure, thin), and
/// without characters of no width (byte order marks, zero-width spaces, word joiners). A blank between thousands, "1
/// 000", is left out, except a plain one.
std::string with_plain_blanks(std::string text);

/// Returns UTF-8 with a hyphen, which number parsers expect, for Unicode's minus sign.
std::string with_plain_minus(std::string text);

/// Returns the text without blanks of any kind, tabs and characters of no width at its ends; those within stay.
std::string_view trim_all(std::string_view text);

}  // namespace decid::recording
