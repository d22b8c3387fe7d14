// Text for users and files: see text.hpp.
#include "base/text.hpp"

#include <charconv>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <string_view>
#include <system_error>

namespace decid {

std::string one_line(std::string text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte < ' ' || byte == 0x7f) text[i] = '?';
    // U+0080 to U+009F, which terminals also interpret: C2 80 to C2 9F.
    if (byte == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0) text.replace(i, 2, "?");
  }
  return text;
}

std::string format(const char* pattern, ...) {
  std::va_list arguments, again;
  va_start(arguments, pattern);
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, pattern, arguments);
  va_end(arguments);
  std::string text(static_cast<std::size_t>(length < 0 ? 0 : length), '\0');
  if (length > 0) std::vsnprintf(text.data(), text.size() + 1, pattern, again);
  va_end(again);
  return text;
}

std::string errno_text(int error) {
  return std::generic_category().message(error);
}

std::string counted(long long count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string duration_text(double seconds) {
  const auto s = static_cast<long long>(std::ceil(seconds));
  if (s < 60) return std::to_string(s) + " s";
  if (s < 3600) return std::to_string(s / 60) + " min " + std::to_string(s % 60) + " s";
  return std::to_string(s / 3600) + " h " + std::to_string(s / 60 % 60) + " min";
}

std::string csv_cell(const std::string& text) {
  // Spreadsheets treat text with these beginnings as formulas; an apostrophe prevents that.
  if (!text.empty() && std::string_view("=+-@\t\r").find(text.front()) != std::string_view::npos)
    return csv_cell("'" + text);
  const bool blank_end = text.starts_with(' ') || text.ends_with(' ');  // some readers drop blanks at the ends
  if (text.find_first_of(",\"\r\n") == std::string::npos && !blank_end) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string csv(const std::vector<std::string>& header, const std::vector<std::vector<double>>& columns, int digits) {
  std::string text;
  for (std::size_t c = 0; c < header.size(); ++c) text += (c > 0 ? "," : "") + header[c];
  text += '\n';
  for (std::size_t row = 0; row < columns.front().size(); ++row) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      char number[40];
      const auto end =
          std::to_chars(number, number + sizeof number, columns[c][row], std::chars_format::general, digits);
      if (c > 0) text += ',';
      text.append(number, end.ptr);
    }
    text += '\n';
  }
  return text;
}

}  // namespace decid
