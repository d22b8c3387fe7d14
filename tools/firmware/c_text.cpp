// Text of C: see c_text.hpp.
#include "tools/firmware/c_text.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <type_traits>

#include "base/error.hpp"
#include "base/text.hpp"

namespace decid::tools {
namespace {

/// Headers of C, to C23. Some file systems have no capital letters.
constexpr const char* standard_headers[] = {
    "assert",    "complex", "ctype",   "errno",  "fenv",   "float",     "inttypes", "iso646",
    "limits",    "locale",  "math",    "setjmp", "signal", "stdalign",  "stdarg",   "stdbit",
    "stdatomic", "stdbool", "stddef",  "stdint", "stdio",  "stdckdint", "stdlib",   "stdnoreturn",
    "string",    "tgmath",  "threads", "time",   "uchar",  "wchar",     "wctype"};

std::string element(float value) {
  return literal(value);
}
std::string element(double value) {
  return literal(value);
}
template <class T>
requires std::is_integral_v<T> std::string element(T value) {
  return std::is_same_v<T, std::uint32_t> ? format("0x%08xU", static_cast<unsigned>(value))
                                          : std::to_string(static_cast<long long>(value));
}

}  // namespace

std::string define(const std::string& name, long long value) {
  return "#define " + name + " " + std::to_string(value) + "\n";
}

std::string define_double(const std::string& name, double value) {
  return "#define " + name + " " + literal(value) + "\n";
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  return text.replace(text.find(what), what.size(), by);
}

std::string literal(float value) {
  return literal(static_cast<double>(value), 9) + "F";
}

std::string literal(double value, int digits) {
  if (!std::isfinite(value))
    throw Error(Code::file_damaged, "export", "a number of the model is infinite or not a number",
                "train the model again");
  std::string text = format("%.*g", digits, value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string comment(const std::string& text) {
  std::string safe = one_line(text);
  std::ranges::replace(safe, '*', '?');
  return safe;
}

std::string quoted(const std::string& text) {
  std::string literal = "\"";
  for (const char c : one_line(text)) {
    if (c == '"' || c == '\\' || c == '?') literal += '\\';  // ?: trigraphs
    literal += c;
  }
  return literal + "\"";
}

template <class T>
std::string table(const std::string& declaration, const std::vector<T>& values) {
  constexpr std::size_t width = 116;
  std::string text = declaration + " = {\n", line = "   ";
  for (const T value : values) {
    const std::string item = " " + element(value) + ",";
    if (line.size() + item.size() > width) {
      text += line + "\n";
      line = "   ";
    }
    line += item;
  }
  return text + line + "\n};\n";
}

template std::string table(const std::string&, const std::vector<double>&);
template std::string table(const std::string&, const std::vector<float>&);
template std::string table(const std::string&, const std::vector<int>&);
template std::string table(const std::string&, const std::vector<std::int8_t>&);
template std::string table(const std::string&, const std::vector<std::uint8_t>&);
template std::string table(const std::string&, const std::vector<std::uint32_t>&);

std::string with_name(std::string text, const std::string& name) {
  const std::string token = "DECID_FW";
  std::string upper = name;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (std::size_t at = text.find(token); at != std::string::npos; at = text.find(token, at)) {
    const std::size_t after = at + token.size();
    const bool small =
        after + 1 < text.size() && text[after] == '_' && text[after + 1] >= 'a' && text[after + 1] <= 'z';
    text.replace(at, token.size(), small ? name : upper);
    at += name.size();
  }
  return text;
}

bool is_c_header(const std::string& name) {
  return std::ranges::count(standard_headers, lower_case(name)) > 0;
}

void check_firmware_name(const std::string& name) {
  const auto allowed = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  if (name.empty() || name.size() > 40 || std::isalpha(static_cast<unsigned char>(name.front())) == 0 ||
      !std::ranges::all_of(name, allowed))
    throw Error(Code::setting_malformed, "--name", "'" + name + "' cannot begin the names of C functions",
                "give up to 40 letters, digits and underscores, a letter first");
  if (is_c_header(name))
    throw Error(Code::setting_malformed, "--name",
                "'" + name + "' is the name of a header of C, which " + name + ".h would replace", "give another name");
}

std::vector<std::uint32_t> to_bits(const std::vector<float>& values) {
  std::vector<std::uint32_t> bits;
  for (const float value : values) bits.push_back(std::bit_cast<std::uint32_t>(value));
  return bits;
}

}  // namespace decid::tools
