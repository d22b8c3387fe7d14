// std::from_chars of a double, which libc++ 19 does not have: the number's extent by the standard's grammar, its value
// by the C library's strtod, which rounds correctly.
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string>

namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// The end of the digits that begin at `at`.
const char* past_digits(const char* at, const char* last) {
  while (at != last && is_digit(*at)) ++at;
  return at;
}

/// The end of `word`, in either case, if it begins at `at`; else `at`.
const char* past_word(const char* at, const char* last, const char* word) {
  const char* c = at;
  for (; *word != '\0'; ++word, ++c)
    if (c == last || (*c | 0x20) != *word) return at;
  return c;
}

/// The end of a number without its sign; `at` if there is none.
const char* past_number(const char* at, const char* last) {
  if (const char* end = past_word(at, last, "infinity"); end != at) return end;
  if (const char* end = past_word(at, last, "inf"); end != at) return end;
  if (const char* end = past_word(at, last, "nan"); end != at) return end;
  const char* const whole = past_digits(at, last);
  const char* end = whole;
  if (end != last && *end == '.') end = past_digits(end + 1, last);
  if (whole == at && end <= whole + 1) return at;
  if (end != last && (*end | 0x20) == 'e') {
    const char* digits = end + 1;
    if (digits != last && (*digits == '+' || *digits == '-')) ++digits;
    if (const char* exponent = past_digits(digits, last); exponent != digits) end = exponent;
  }
  return end;
}

}  // namespace

_LIBCPP_BEGIN_NAMESPACE_STD

from_chars_result from_chars(const char* first, const char* last, double& value) {
  const char* const number = first != last && *first == '-' ? first + 1 : first;
  const char* const end = past_number(number, last);
  if (end == number) return {first, errc::invalid_argument};
  const double found = std::strtod(std::string(first, end).c_str(), nullptr);
  const bool is_digits = is_digit(*number) || *number == '.';
  const auto is_significant = [&] {
    for (const char* c = number; c != end && (*c | 0x20) != 'e'; ++c)
      if (*c >= '1' && *c <= '9') return true;
    return false;
  };
  if (is_digits && (std::isinf(found) || (found == 0.0 && is_significant()))) return {end, errc::result_out_of_range};
  value = found;
  return {end, errc()};
}

_LIBCPP_END_NAMESPACE_STD
