// Keys of names: see text_key.hpp.
#include "identify/study/detail/text_key.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <string>

namespace decid {
namespace {

/// A combining accent, and pairs of letters: plain, with the accent.
struct Accent {
  char32_t mark;
  std::string_view letters;
};
constexpr Accent accents[] = {
    {U'\u0300', "AÀEÈIÌOÒUÙaàeèiìoòuù"},
    {U'\u0301', "AÁEÉIÍOÓUÚYÝaáeéiíoóuúyýCĆcćLĹlĺNŃnńRŔrŕSŚsśZŹzź"},
    {U'\u0302', "AÂEÊIÎOÔUÛaâeêiîoôuûCĈcĉGĜgĝHĤhĥJĴjĵSŜsŝWŴwŵYŶyŷ"},
    {U'\u0303', "AÃNÑOÕaãnñoõIĨiĩUŨuũ"},
    {U'\u0304', "AĀaāEĒeēIĪiīOŌoōUŪuū"},
    {U'\u0306', "AĂaăEĔeĕGĞgğIĬiĭOŎoŏUŬuŭ"},
    {U'\u0307', "CĊcċEĖeėGĠgġIİZŻzż"},
    {U'\u0308', "AÄEËIÏOÖUÜaäeëiïoöuüyÿYŸ"},
    {U'\u030A', "AÅaåUŮuů"},
    {U'\u030B', "OŐoőUŰuű"},
    {U'\u030C', "CČcčDĎdďEĚeěLĽlľNŇnňRŘrřSŠsšTŤtťZŽzžAǍaǎIǏiǐOǑoǒUǓuǔ"},
    {U'\u0326', "SȘsșTȚtț"},
    {U'\u0327', "CÇcçGĢgģKĶkķLĻlļNŅnņRŖrŗSŞsşTŢtţ"},
    {U'\u0328', "AĄaąEĘeęIĮiįUŲuų"},
};

struct Character {
  char32_t code = 0;
  std::size_t bytes = 1;  ///< 1 also for a byte that begins no character
  bool is_valid = false;
};

/// Reads the character of UTF-8 at the beginning of `text`, which is not empty.
Character first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return {first, 1, true};
  const std::size_t bytes = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : first >= 0xC0 ? 2 : 0;
  if (bytes == 0 || bytes > text.size()) return {};
  auto code = static_cast<char32_t>(first & (0x7F >> bytes));
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return {};
    code = (code << 6U) | (byte(i) & 0x3FU);
  }
  return {code, bytes, true};
}

std::string utf8(char32_t code) {
  const auto byte = [](char32_t value) { return static_cast<char>(static_cast<unsigned char>(value)); };
  if (code < 0x80) return {byte(code)};
  if (code < 0x800) return {byte(0xC0 | (code >> 6U)), byte(0x80 | (code & 0x3FU))};
  if (code < 0x10000)
    return {byte(0xE0 | (code >> 12U)), byte(0x80 | ((code >> 6U) & 0x3FU)), byte(0x80 | (code & 0x3FU))};
  return {byte(0xF0 | (code >> 18U)), byte(0x80 | ((code >> 12U) & 0x3FU)), byte(0x80 | ((code >> 6U) & 0x3FU)),
          byte(0x80 | (code & 0x3FU))};
}

/// Returns the small letter of a letter without an accent.
char32_t small_letter(char32_t code) {
  const auto within = [&](char32_t low, char32_t high) { return code >= low && code <= high; };
  if (within(U'A', U'Z') || within(0xC0, 0xDE) || within(0x391, 0x3A9) || within(0x410, 0x42F)) return code + 0x20;
  if (within(0x400, 0x40F)) return code + 0x50;
  const bool paired = code == 0x110 || code == 0x126 || code == 0x132 || code == 0x13F || code == 0x141 ||
                      code == 0x14A || code == 0x152 || code == 0x166;  // Latin letters with a stroke, and ligatures
  return paired ? code + 1 : code;
}

using Letters = std::map<char32_t, std::pair<char32_t, char32_t>>;

/// Returns the letter and the accent of each accented letter.
const Letters& decompositions() {
  static const Letters all = [] {
    Letters made;
    for (const Accent& accent : accents) {
      for (std::string_view rest = accent.letters; !rest.empty();) {
        const auto letter = static_cast<char32_t>(rest.front());
        const Character whole = first_character(rest.substr(1));
        made[whole.code] = {letter, accent.mark};
        rest.remove_prefix(1 + whole.bytes);
      }
    }
    return made;
  }();
  return all;
}

}  // namespace

std::string text_key(std::string_view text) {
  std::string key;
  while (!text.empty()) {
    const Character next = first_character(text);
    if (!next.is_valid) {
      key += text.front();
    } else if (const auto found = decompositions().find(next.code); found != decompositions().end()) {
      key += utf8(small_letter(found->second.first)) + utf8(found->second.second);
    } else {
      key += utf8(small_letter(next.code));
    }
    text.remove_prefix(next.bytes);
  }
  return key;
}

std::string column_key(std::string_view name) {
  std::string key = text_key(name);
  std::erase_if(key,
                [](char c) { return std::string_view(" _-.,:;#?'\"/\\()[]{}<>").find(c) != std::string_view::npos; });
  return key;
}

std::vector<std::string> column_keys(std::span<const std::string_view> names) {
  std::vector<std::string> keys;
  std::ranges::transform(names, std::back_inserter(keys), column_key);
  return keys;
}

std::string without_point_zero(const std::string& cell) {
  const std::size_t point = cell.find_first_of(".,"), first = cell.starts_with('-') ? 1 : 0;
  const auto is_of = [&](std::size_t from, std::size_t to, const char* digits) {
    return from < to && cell.find_first_not_of(digits, from) >= to;
  };
  const bool is_whole = point != std::string::npos && is_of(first, point, "0123456789") &&
                        is_of(point + 1, cell.size(), "0") && (cell[point] == '.' || cell.size() - point != 4);
  return is_whole ? cell.substr(0, point) : cell;
}

}  // namespace decid
