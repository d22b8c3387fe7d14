// Parameters as text: see parameters.hpp.
#include "sim/parameters.hpp"

#include <charconv>
#include <cmath>
#include <set>
#include <sstream>

#include "base/error.hpp"

namespace decid::sim {

std::string unit_after(const ParameterInfo& info) {
  const std::string unit = info.shown_unit();
  return unit.empty() ? unit : " " + unit;
}

Parameters parameters_from_text(const std::string& text, const std::string& where) {
  const auto fail = [&](const std::string& problem) {
    throw Error(where, problem, "give all seven as Kp=..,Kd=..,Kp_pass=..,Kd_pass=..,Nv=..,theta=..,delay=..");
  };
  Parameters parameters{};
  std::set<std::size_t> given;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos) fail("'" + part + "' is not NAME=VALUE");
    const std::string name = part.substr(0, equals), value = part.substr(equals + 1);
    std::size_t index = 0;
    while (index < parameter_count && name != parameter_info[index].name && name != parameter_info[index].option)
      ++index;
    if (index == parameter_count) fail("'" + name + "' is not a parameter");
    if (!given.insert(index).second) fail("gives " + name + " twice");
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), parameters[index]);
    if (error != std::errc() || end != value.data() + value.size() || !std::isfinite(parameters[index]))
      fail("'" + value + "' is not a number");
  }
  if (given.size() != parameter_count) fail("gives " + std::to_string(given.size()) + " of 7 parameters");
  return parameters;
}

}  // namespace decid::sim
