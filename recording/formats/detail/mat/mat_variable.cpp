// Text of MAT-files: see mat_variable.hpp.
#include "recording/formats/detail/mat/mat_variable.hpp"

#include "recording/formats/encoding.hpp"

namespace decid::recording {

namespace {

/// Returns the character, or a question mark for an invalid one.
std::uint32_t valid(std::uint32_t character) {
  return character < 0xD800 || (character > 0xDFFF && character < 0x110000) ? character : std::uint32_t{'?'};
}

}  // namespace

std::vector<std::string> text_rows(const std::vector<std::uint32_t>& characters, std::size_t height,
                                   std::size_t width) {
  if (characters.empty()) return {};
  std::vector<std::string> rows(height);
  for (std::size_t row = 0; row < height; ++row) {
    for (std::size_t at = 0; at < width; ++at) append_utf8(rows[row], valid(characters[at * height + row]));
    while (!rows[row].empty() && (rows[row].back() == ' ' || rows[row].back() == '\0')) rows[row].pop_back();
  }
  return rows;
}

}  // namespace decid::recording
