// Text encodings: see encoding.hpp. Sources: RFC 3629 (UTF-8), RFC 2781 (UTF-16), the WHATWG Encoding Standard's index
// of windows-1252.
#include "recording/formats/encoding.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "base/error.hpp"
#include "recording/table/cells.hpp"

namespace decid::recording {

namespace {

std::string from_utf16(std::string_view bytes, bool little_endian) {
  const auto unit = [&](std::size_t at) {
    const auto first = static_cast<unsigned char>(bytes[at]), second = static_cast<unsigned char>(bytes[at + 1]);
    return static_cast<std::uint32_t>(little_endian ? second << 8U | first : first << 8U | second);
  };
  std::string text;
  text.reserve(bytes.size() / 2);
  for (std::size_t at = 0; at + 1 < bytes.size(); at += 2) {
    std::uint32_t point = unit(at);
    const bool leads = point >= 0xD800U && point < 0xDC00U && at + 3 < bytes.size();
    if (leads && unit(at + 2) >= 0xDC00U && unit(at + 2) < 0xE000U) {
      point = 0x10000U + ((point - 0xD800U) << 10U) + (unit(at + 2) - 0xDC00U);
      at += 2;
    } else if (point >= 0xD800U && point < 0xE000U) {
      point = 0xFFFDU;  // an unpaired surrogate
    }
    if (point != 0xFEFFU) append_utf8(text, point);
  }
  return text;
}

/// Returns the bytes of the UTF-8 character that starts here; 0 if it is not UTF-8.
std::size_t character(std::string_view text) {
  const auto first = static_cast<unsigned char>(text.front());
  const std::size_t length = first < 0x80   ? 1
                             : first < 0xC2 ? 0
                             : first < 0xE0 ? 2
                             : first < 0xF0 ? 3
                             : first < 0xF5 ? 4
                                            : 0;
  if (length == 0 || length > text.size()) return 0;
  // Longer than needed, half of a surrogate pair, or beyond U+10FFFF.
  const auto second = static_cast<unsigned char>(length > 1 ? text[1] : '\0');
  if ((first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F) || (first == 0xF0 && second < 0x90) ||
      (first == 0xF4 && second > 0x8F))
    return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((static_cast<unsigned char>(text[i]) & 0xC0U) != 0x80U) return 0;
  return length;
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    std::uint64_t eight = 0;  // eight ASCII bytes at a time
    if (text.size() >= sizeof eight) {
      std::memcpy(&eight, text.data(), sizeof eight);
      if ((eight & 0x8080808080808080U) == 0) {
        text.remove_prefix(sizeof eight);
        continue;
      }
    }
    const std::size_t length = character(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

std::string from_windows_1252(std::string_view bytes) {
  // The characters 0x80 to 0x9F; other bytes are their own code points.
  constexpr std::array<std::uint16_t, 32> high = {0x20AC, 0x0081, 0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021,
                                                  0x02C6, 0x2030, 0x0160, 0x2039, 0x0152, 0x008D, 0x017D, 0x008F,
                                                  0x0090, 0x2018, 0x2019, 0x201C, 0x201D, 0x2022, 0x2013, 0x2014,
                                                  0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0x009D, 0x017E, 0x0178};
  std::string text;
  text.reserve(bytes.size() + bytes.size() / 16);
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    append_utf8(text, byte >= 0x80 && byte < 0xA0 ? high[byte - 0x80U] : byte);
  }
  return text;
}

/// Returns true if every second one of the first bytes, and no other, is null: digits and letters in UTF-16 without a
/// mark. `odd`: the second byte of each pair, as in little endian.
bool has_nulls_at(std::string_view bytes, bool odd) {
  const std::string_view start = bytes.substr(0, 64);
  if (start.size() < 8) return false;
  for (std::size_t i = 0; i < start.size(); ++i)
    if ((start[i] == '\0') != ((i % 2 == 1) == odd)) return false;
  return true;
}

constexpr std::array<std::string_view, 4> other_blanks = {"\u00A0", "\u2007", "\u2009", "\u202F"};
constexpr std::array<std::string_view, 3> of_no_width = {"\u200B", "\u2060", "\uFEFF"};

/// Returns the length of the one of `characters` with which the text begins; 0 without one.
template <std::size_t N>
std::size_t length_at_start(std::string_view text, const std::array<std::string_view, N>& characters) {
  for (const std::string_view character : characters)
    if (text.starts_with(character)) return character.size();
  return 0;
}

/// Returns true for exactly three digits at the start, as behind a separator of thousands.
bool begins_with_group(std::string_view text) {
  const auto is_digit = [&](std::size_t i) { return i < text.size() && text[i] >= '0' && text[i] <= '9'; };
  return is_digit(0) && is_digit(1) && is_digit(2) && !is_digit(3);
}

}  // namespace

void append_utf8(std::string& text, std::uint32_t point) {
  const auto tail = [&](int shift) { text += static_cast<char>(0x80U | ((point >> shift) & 0x3FU)); };
  if (point < 0x80U) {
    text += static_cast<char>(point);
  } else if (point < 0x800U) {
    text += static_cast<char>(0xC0U | (point >> 6U));
    tail(0);
  } else if (point < 0x10000U) {
    text += static_cast<char>(0xE0U | (point >> 12U));
    tail(6);
    tail(0);
  } else {
    text += static_cast<char>(0xF0U | (point >> 18U));
    tail(12);
    tail(6);
    tail(0);
  }
}

std::string with_plain_blanks(std::string text) {
  constexpr std::string_view first_bytes = "\xC2\xE2\xEF";
  const auto has = [&](char byte) { return text.find(byte) != text.npos; };
  if (std::ranges::none_of(first_bytes, has)) return text;
  const std::string_view view = text;
  std::size_t at = view.find_first_of(first_bytes);
  std::string plain;
  plain.reserve(text.size());
  for (std::size_t begin = 0; begin < text.size(); at = text.find_first_of(first_bytes, begin)) {
    plain += view.substr(begin, at - begin);
    if (at == text.npos) break;
    const std::string_view rest = view.substr(at);
    const std::size_t blank = length_at_start(rest, other_blanks), nothing = length_at_start(rest, of_no_width);
    const bool is_within_number = blank > 0 && !plain.empty() && plain.back() >= '0' && plain.back() <= '9' &&
                                  begins_with_group(rest.substr(blank));
    if (blank > 0 && !is_within_number) plain += ' ';
    if (blank + nothing == 0) plain += rest.front();
    begin = at + std::max<std::size_t>(blank + nothing, 1);
  }
  return plain;
}

std::string with_plain_minus(std::string text) {
  constexpr std::string_view minus = "\xE2\x88\x92";
  std::size_t at = text.find(minus);
  if (at == text.npos) return text;
  std::string plain = text.substr(0, at);
  for (std::size_t begin = at; at != text.npos; at = text.find(minus, begin)) {
    plain += text.substr(begin, at - begin) + "-";
    begin = at + minus.size();
  }
  return plain + text.substr(text.rfind(minus) + minus.size());
}

std::string_view trim_all(std::string_view text) {
  const auto trim_of = [&](const auto& characters) {
    for (const std::string_view character : characters) {
      if (text.starts_with(character)) text.remove_prefix(character.size());
      if (text.ends_with(character)) text.remove_suffix(character.size());
    }
  };
  for (std::size_t before = text.size() + 1; text.size() < before;) {
    before = text.size();
    text = trim(text);
    trim_of(other_blanks);
    trim_of(of_no_width);
  }
  return text;
}

std::string to_utf8(std::string bytes, const std::string& where) {
  using namespace std::string_view_literals;
  std::string_view view = bytes;
  if (view.starts_with("\xFF\xFE"sv) || has_nulls_at(view, true)) {
    bytes = from_utf16(view, true);
  } else if (view.starts_with("\xFE\xFF"sv) || has_nulls_at(view, false)) {
    bytes = from_utf16(view, false);
  }
  while (bytes.starts_with("\xEF\xBB\xBF")) bytes.erase(0, 3);  // some programs write a second one
  bytes.resize(bytes.find_last_not_of('\0') + 1);               // padding of programs that set a file's size beforehand
  if (bytes.find('\0') != std::string::npos)
    throw Error(Code::file_unsupported, where, "is not a text file",
                "save it as CSV, in UTF-8, UTF-16 or Windows-1252");
  if (is_utf8(bytes)) return bytes;
  return from_windows_1252(bytes);
}

}  // namespace decid::recording
