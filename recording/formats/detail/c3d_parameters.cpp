// Parameters of C3D files: see c3d_parameters.hpp. A file may claim anything, so every record is checked against the
// bytes present. Format: the manual of c3d.org.
#include "recording/formats/detail/c3d_parameters.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "base/error.hpp"
#include "recording/formats/encoding.hpp"

namespace decid::recording {

namespace {

constexpr std::size_t section_header_bytes = 4;

/// Returns the value of DEC's F_floating: a sign, an exponent biased by 128, and a mantissa of at least 0.1 binary.
double dec_real(std::uint32_t bits) {
  const std::uint32_t exponent = (bits >> 23U) & 0xFFU;
  const bool negative = (bits >> 31U) != 0;
  if (exponent == 0) return negative ? std::numeric_limits<double>::quiet_NaN() : 0.0;
  const double mantissa = static_cast<double>((bits & 0x7FFFFFU) | 0x800000U);
  return std::ldexp(negative ? -mantissa : mantissa, static_cast<int>(exponent) - 128 - 24);
}

std::string capitals(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return result;
}

/// Returns a text without its padding of nulls and blanks.
std::string plain_text(std::string_view text, const std::string& where) {
  text = text.substr(0, text.find('\0'));
  const auto is_blank = [](char c) { return static_cast<unsigned char>(c) <= ' '; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return with_plain_blanks(to_utf8(std::string(text), where));
}

/// Reads a parameter's values, beginning at its type byte. `end`: the first byte after them.
C3dParameter read_parameter(const C3dBytes& bytes, std::size_t at, std::size_t& end) {
  const int type = bytes.signed_byte(at);
  const std::size_t dimensions = bytes.byte(at + 1), size = type < 0 ? 1 : static_cast<std::size_t>(type);
  at += 2;
  if (type != -1 && type != 1 && type != 2 && type != 4)
    refuse_damaged_c3d(bytes.where(), "a parameter has the unknown type " + std::to_string(type));
  std::size_t values = 1, length = 1;
  for (std::size_t d = 0; d < dimensions; ++d) {
    const std::size_t extent = bytes.byte(at++);
    if (d == 0) length = extent;
    values *= extent;
    if (values * size > bytes.size()) refuse_damaged_c3d(bytes.where(), "a parameter is longer than the file");
  }
  C3dParameter parameter;
  end = at + values * size;
  if (type == -1) {
    const std::string_view all = bytes.text(at, values);
    for (std::size_t k = 0; length > 0 && k < values; k += length)
      parameter.texts.push_back(plain_text(all.substr(k, length), bytes.where()));
    return parameter;
  }
  for (; at < end; at += size)
    parameter.numbers.push_back(size == 1 ? bytes.byte(at) : size == 2 ? bytes.integer(at) : bytes.real(at));
  return parameter;
}

}  // namespace

void refuse_damaged_c3d(const std::string& where, const std::string& what) {
  throw Error(Code::file_damaged, where, "is a C3D file that is cut short or damaged: " + what,
              "copy it again, or export the points as text (.trc, .csv)");
}

std::string_view C3dBytes::text(std::size_t at, std::size_t count) const {
  if (at > bytes_.size() || count > bytes_.size() - at)
    refuse_damaged_c3d(*where_, "it ends at byte " + std::to_string(bytes_.size()) + ", before its content does");
  return bytes_.substr(at, count);
}

std::uint16_t C3dBytes::word(std::size_t at) const {
  const std::string_view raw = text(at, 2);
  const auto first = static_cast<std::uint8_t>(raw[0]), second = static_cast<std::uint8_t>(raw[1]);
  return static_cast<std::uint16_t>(processor_ == Processor::mips ? first * 256 + second : second * 256 + first);
}

double C3dBytes::real(std::size_t at) const {
  const std::uint32_t first = word(at), second = word(at + 2);
  if (processor_ == Processor::intel) return std::bit_cast<float>(second << 16U | first);
  const std::uint32_t bits = first << 16U | second;
  return processor_ == Processor::dec ? dec_real(bits) : std::bit_cast<float>(bits);
}

C3dParameters::C3dParameters(const C3dBytes& bytes, std::size_t begin) {
  struct Found {
    int group;
    std::string name;
    C3dParameter parameter;
  };
  std::map<int, std::string> groups;
  std::vector<Found> found;  // The file may name a group after its parameters.
  // A record holds the name's length, its group, the name, the distance to the next record, and the content.
  for (std::size_t at = begin + section_header_bytes; at + 2 <= bytes.size();) {
    const auto length = static_cast<std::size_t>(std::abs(bytes.signed_byte(at)));  // negative: locked
    const int group = bytes.signed_byte(at + 1);
    if (length == 0 || group == 0) break;
    const std::string name = capitals(bytes.text(at + 2, length));
    at += 2 + length;
    const std::size_t next = bytes.word(at);
    std::size_t end = at + 2;
    if (group < 0) {
      groups.emplace(-group, name);
    } else {
      C3dParameter parameter = read_parameter(bytes, at + 2, end);
      found.push_back({group, name, std::move(parameter)});
    }
    if (next == 0) break;
    if (at + next < end) refuse_damaged_c3d(bytes.where(), "the parameter " + name + " overlaps the next one");
    at += next;
  }
  for (Found& one : found) {
    if (const auto group = groups.find(one.group); group != groups.end())
      parameters_.emplace(group->second + ":" + one.name, std::move(one.parameter));
  }
}

const C3dParameter* C3dParameters::find(const std::string& name) const {
  const auto found = parameters_.find(name);
  return found == parameters_.end() ? nullptr : &found->second;
}

double C3dParameters::number(const std::string& name, double otherwise) const {
  const C3dParameter* const parameter = find(name);
  return parameter == nullptr || parameter->numbers.empty() ? otherwise : parameter->numbers.front();
}

double C3dParameters::count(const std::string& name, double otherwise) const {
  const double value = number(name, otherwise);
  return value < 0.0 ? value + 65536.0 : value;
}

std::string C3dParameters::text(const std::string& name) const {
  const C3dParameter* const parameter = find(name);
  return parameter == nullptr || parameter->texts.empty() ? "" : parameter->texts.front();
}

template <class Visit>
void C3dParameters::visit_parts(const std::string& name, const Visit& visit) const {
  const C3dParameter* part = find(name);
  for (int number = 2; part != nullptr; ++number) {
    visit(*part);
    part = find(name + std::to_string(number));
  }
}

std::vector<double> C3dParameters::numbers(const std::string& name) const {
  std::vector<double> all;
  visit_parts(name, [&](const C3dParameter& part) { all.insert(all.end(), part.numbers.begin(), part.numbers.end()); });
  return all;
}

std::vector<std::string> C3dParameters::texts(const std::string& name) const {
  std::vector<std::string> all;
  visit_parts(name, [&](const C3dParameter& part) { all.insert(all.end(), part.texts.begin(), part.texts.end()); });
  return all;
}

}  // namespace decid::recording
