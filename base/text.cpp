// Text for users and files: see text.hpp.
#include "base/text.hpp"

#include <algorithm>
#include <charconv>
#include <clocale>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numeric>
#include <system_error>
#include <utility>
#include <vector>

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

namespace {

/// The number of bytes at the beginning of `text` that are a character of UTF-8, or the beginning of one; and whether
/// it is whole. RFC 3629; Unicode 15, table 3-7.
std::pair<std::size_t, bool> character_at(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  if (first < 0x80) return {1, true};
  const std::size_t size = first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : first < 0xF5 ? 4 : 0;
  if (size == 0) return {1, false};
  const unsigned low = first == 0xE0 ? 0xA0 : first == 0xF0 ? 0x90 : 0x80;
  const unsigned high = first == 0xED ? 0x9F : first == 0xF4 ? 0x8F : 0xBF;
  std::size_t i = 1;
  if (i < text.size() && byte(i) >= low && byte(i) <= high)
    for (i = 2; i < size && i < text.size() && byte(i) >= 0x80 && byte(i) <= 0xBF;) ++i;
  return {i, i == size};
}

/// Gives the thread the locale "C" until the end of its scope: a host's locale may have decimal commas, which decid
/// could not read back.
class PlainLocale {
 public:
  PlainLocale() : before_(::uselocale(plain())) {}
  ~PlainLocale() { ::uselocale(before_); }
  PlainLocale(const PlainLocale&) = delete;
  PlainLocale& operator=(const PlainLocale&) = delete;

 private:
  static locale_t plain() {
    static const locale_t made = ::newlocale(LC_ALL_MASK, "C", nullptr);
    return made;
  }
  locale_t before_;
};

}  // namespace

std::string valid_utf8(std::string_view text) {
  std::string valid;
  while (!text.empty()) {
    const auto [size, is_whole] = character_at(text);
    valid += is_whole ? text.substr(0, size) : "\xEF\xBF\xBD";
    text.remove_prefix(size);
  }
  return valid;
}

std::string format(const char* pattern, ...) {
  const PlainLocale locale;
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

std::string lower_case(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

// V. Levenshtein, Soviet Physics Doklady 10 (1966) 707-710.
std::size_t count_edits(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0U : 1U);
      diagonal = row[j];
      row[j] = std::min({changed, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

std::string duration_text(double seconds) {
  const auto s = static_cast<long long>(std::ceil(seconds));
  if (s < 60) return std::to_string(s) + " s";
  if (s < 3600) return std::to_string(s / 60) + " min " + std::to_string(s % 60) + " s";
  return std::to_string(s / 3600) + " h " + std::to_string(s / 60 % 60) + " min";
}

namespace {

/// Returns true for a sign, digits, and digits after a point or a comma: "-1.5", "+3", "-0,25".
bool is_decimal(std::string_view text) {
  const auto take_digits = [&text] {
    const std::size_t end = std::min(text.find_first_not_of("0123456789"), text.size());
    text.remove_prefix(end);
    return end > 0;
  };
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  if (!take_digits()) return false;
  if (!text.starts_with('.') && !text.starts_with(',')) return text.empty();
  text.remove_prefix(1);
  return take_digits() && text.empty();
}

}  // namespace

std::string csv_cell(const std::string& text) {
  // Spreadsheets treat text with these beginnings as formulas; an apostrophe prevents that. Numbers stay numbers.
  if (!text.empty() && std::string_view("=+-@\t\r").find(text.front()) != std::string_view::npos && !is_decimal(text))
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

std::string shell_quoted(const std::string& text) {
  constexpr std::string_view plain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./=,:+-";
  if (!text.empty() && text.find_first_not_of(plain) == std::string::npos) return text;
  std::string quoted = "'";
  for (const char c : text)
    if (c == '\'')
      quoted += "'\\''";
    else
      quoted += c;
  return quoted + "'";
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
