// Compares names as people spell them: letter case, and accents as one character or two (NFC, NFD), do not count.
// Accents: Unicode 15, canonical decompositions of Latin letters up to U+01DC and of U+0218 to U+021B. Not installed.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace decid {

/// Returns a key that equal names share: accents follow their letters as characters of their own, letters are small.
/// text: UTF-8; other bytes stay as they are.
std::string text_key(std::string_view text);

/// Returns text_key() without blanks, underscores and punctuation: "Participant ID" and "participant_id" are one, and
/// so are "VP-Nr." and "vp nr". Signs of numbers (%, +, *, =) stay.
std::string column_key(std::string_view name);

/// Returns a whole number as people write it, "1", where a program wrote "1.0"; any other text as it is, such as
/// "1,000", which may be a thousand.
std::string without_point_zero(const std::string& cell);

/// Returns the column_key() of each name, for tables of names that many columns are compared with.
std::vector<std::string> column_keys(std::span<const std::string_view> names);

}  // namespace decid
