// Text of MAT-files: see mat_variable.hpp.
#include "recording/formats/detail/mat/mat_variable.hpp"

namespace decid::recording {

namespace {

/// Appends a character to a text in UTF-8; an invalid character becomes a question mark.
void append_character(std::string& text, std::uint32_t character) {
  const bool is_one = character < 0xD800 || (character > 0xDFFF && character < 0x110000);
  if (!is_one) {
    text += '?';
  } else if (character < 0x80) {
    text += static_cast<char>(character);
  } else {
    const int more = character < 0x800 ? 1 : character < 0x10000 ? 2 : 3;
    constexpr std::uint32_t first[]{0, 0xC0, 0xE0, 0xF0};
    text += static_cast<char>(first[more] | character >> 6 * more);
    for (int i = more - 1; i >= 0; --i) text += static_cast<char>(0x80 | (character >> 6 * i & 0x3F));
  }
}

}  // namespace

std::vector<std::string> text_rows(const std::vector<std::uint32_t>& characters, std::size_t height,
                                   std::size_t width) {
  if (characters.empty()) return {};
  std::vector<std::string> rows(height);
  for (std::size_t row = 0; row < height; ++row) {
    for (std::size_t at = 0; at < width; ++at) append_character(rows[row], characters[at * height + row]);
    while (!rows[row].empty() && (rows[row].back() == ' ' || rows[row].back() == '\0')) rows[row].pop_back();
  }
  return rows;
}

}  // namespace decid::recording
