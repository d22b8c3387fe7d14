// Scans XML: see xml_scanner.hpp.
#include "recording/formats/detail/xml_scanner.hpp"

#include <charconv>
#include <cstdint>

#include "base/error.hpp"
#include "recording/formats/encoding.hpp"

namespace decid::recording {

namespace {

constexpr std::string_view blank_characters = " \t\r\n";

/// Returns the name after its prefix.
std::string_view local_name(std::string_view name) {
  const std::size_t colon = name.find(':');
  return colon == name.npos ? name : name.substr(colon + 1);
}

}  // namespace

void XmlScanner::refuse(const char* what) const {
  throw Error(Code::file_damaged, where_, std::string("is a damaged workbook: ") + what,
              "save it again, or save the sheet as CSV");
}

std::string_view XmlScanner::until(std::string_view mark) {
  const std::size_t end = rest_.find(mark);
  if (end == rest_.npos) refuse("a tag does not end");
  const std::string_view taken = rest_.substr(0, end);
  rest_.remove_prefix(end + mark.size());
  return taken;
}

std::string XmlScanner::decoded(std::string_view raw) const {
  std::string text;
  while (true) {
    const std::size_t ampersand = raw.find('&');
    text += raw.substr(0, ampersand);
    if (ampersand == raw.npos) return text;
    const std::size_t end = raw.find(';', ampersand);
    if (end == raw.npos) refuse("an entity does not end");
    std::string_view entity = raw.substr(ampersand + 1, end - ampersand - 1);
    raw.remove_prefix(end + 1);
    if (entity == "lt") text += '<';
    if (entity == "gt") text += '>';
    if (entity == "amp") text += '&';
    if (entity == "quot") text += '"';
    if (entity == "apos") text += '\'';
    if (!entity.starts_with('#')) continue;
    entity.remove_prefix(1);
    const bool is_hex = entity.starts_with('x');
    if (is_hex) entity.remove_prefix(1);
    std::uint32_t code = 0;
    std::from_chars(entity.data(), entity.data() + entity.size(), code, is_hex ? 16 : 10);
    if (code > 0 && code < 0x110000) append_utf8(text, code);
  }
}

XmlScanner::Tag XmlScanner::next() {
  text_.clear();
  if (closes_) {
    closes_ = false;
    return Tag::close;
  }
  while (true) {
    const std::size_t open = rest_.find('<');
    text_ += decoded(rest_.substr(0, open));
    if (open == rest_.npos) return Tag::end;
    rest_.remove_prefix(open + 1);
    if (rest_.starts_with("!--")) {
      until("-->");
    } else if (rest_.starts_with("![CDATA[")) {
      text_ += until("]]>").substr(8);
    } else if (rest_.starts_with("?")) {
      until("?>");
    } else if (rest_.starts_with("!")) {
      refuse("it declares a document type");
    } else {
      break;
    }
  }
  std::string_view tag = until(">");
  const bool ends = tag.starts_with("/");
  if (ends) tag.remove_prefix(1);
  closes_ = !ends && tag.ends_with("/");
  if (closes_) tag.remove_suffix(1);
  const std::size_t blank = tag.find_first_of(blank_characters);
  name_ = local_name(tag.substr(0, blank));
  attributes_ = blank == tag.npos ? std::string_view() : tag.substr(blank);
  return ends ? Tag::close : Tag::open;
}

std::string XmlScanner::attribute(std::string_view name) const {
  std::string_view rest = attributes_;
  while (true) {
    const std::size_t equals = rest.find('=');
    if (equals == rest.npos) return {};
    std::string_view here = rest.substr(0, equals);
    while (!here.empty() && blank_characters.find(here.front()) != blank_characters.npos) here.remove_prefix(1);
    while (!here.empty() && blank_characters.find(here.back()) != blank_characters.npos) here.remove_suffix(1);
    const std::size_t begin = rest.find_first_of("\"'", equals);
    if (begin == rest.npos) return {};
    const std::size_t end = rest.find(rest[begin], begin + 1);
    if (end == rest.npos) return {};
    if (local_name(here) == name) return decoded(rest.substr(begin + 1, end - begin - 1));
    rest.remove_prefix(end + 1);
  }
}

}  // namespace decid::recording
