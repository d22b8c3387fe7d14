// Text in and out of the command line: see text.hpp.
#include "tools/text.hpp"

#include <charconv>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <set>
#include <sstream>

#include "base/error.hpp"

namespace decid::tools {

std::string one_line(std::string text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte < ' ' || byte == 0x7f) text[i] = '?';
    // U+0080 to U+009F, which terminals obey too: C2 80 to C2 9F.
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

std::string unit_after(const sim::ParameterInfo& info) {
  const std::string unit = info.shown_unit();
  return unit.empty() ? unit : " " + unit;
}

sim::Parameters parameters_from_text(const std::string& text, const std::string& where) {
  const auto fail = [&](const std::string& problem) {
    throw Error(where, problem, "give all seven as Kp=..,Kd=..,Kp_pass=..,Kd_pass=..,Nv=..,theta=..,delay=..");
  };
  sim::Parameters parameters{};
  std::set<std::size_t> given;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos) fail("'" + part + "' is not NAME=VALUE");
    const std::string name = part.substr(0, equals), value = part.substr(equals + 1);
    std::size_t index = 0;
    while (index < sim::parameter_count && name != sim::parameter_info[index].name &&
           name != sim::parameter_info[index].option)
      ++index;
    if (index == sim::parameter_count) fail("'" + name + "' is no parameter");
    if (!given.insert(index).second) fail("gives " + name + " twice");
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), parameters[index]);
    if (error != std::errc() || end != value.data() + value.size() || !std::isfinite(parameters[index]))
      fail("'" + value + "' is not a number");
  }
  if (given.size() != sim::parameter_count) fail("gives " + std::to_string(given.size()) + " of 7 parameters");
  return parameters;
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

}  // namespace decid::tools
