// Tables of parameters: see parameters.hpp.
#include "sim/parameters.hpp"

#include <cmath>
#include <set>
#include <sstream>

#include "base/error.hpp"
#include "base/number.hpp"
#include "base/text.hpp"

namespace decid::sim {
namespace {

/// Returns "seven"; numbers above twelve in digits.
std::string in_words(std::size_t count) {
  constexpr const char* words[] = {"no",    "one",   "two",  "three", "four",   "five",  "six",
                                   "seven", "eight", "nine", "ten",   "eleven", "twelve"};
  return count < std::size(words) ? words[count] : std::to_string(count);
}

}  // namespace

ParameterTable::ParameterTable(std::vector<ParameterInfo> parameters) : all_(std::move(parameters)) {
  if (all_.empty() || all_.size() > Parameters::max_parameters)
    throw Error(Code::setting_out_of_range, "parameters", "a table has " + std::to_string(all_.size()) + " rows",
                "give 1 to " + std::to_string(Parameters::max_parameters));
  std::set<std::string> names;
  for (const ParameterInfo& info : all_) {
    if (!names.insert(info.name).second || (info.option != info.name && !names.insert(info.option).second))
      throw Error(Code::setting_conflict, "parameters", "a table has two parameters called " + info.name,
                  "give each its own name");
    if (!(info.low < info.high && info.low >= info.min && info.high <= info.max))
      throw Error(Code::setting_out_of_range, "parameters",
                  "the range of " + info.name + " is empty or cannot be simulated",
                  "give a low end below the high end, both within the allowed values");
  }
}

std::vector<std::string> ParameterTable::names() const {
  std::vector<std::string> names;
  for (const ParameterInfo& info : all_) names.push_back(info.name);
  return names;
}

Parameters ParameterTable::middle() const {
  Parameters middle(size());
  for (std::size_t i = 0; i < size(); ++i) middle[i] = all_[i].middle();
  return middle;
}

Parameters ParameterTable::simulable(Parameters values) const {
  for (std::size_t i = 0; i < size(); ++i) values[i] = std::clamp(values[i], all_[i].min, all_[i].max);
  return values;
}

std::vector<double> ParameterTable::to_unit(const Parameters& values) const {
  std::vector<double> unit;
  for (std::size_t i = 0; i < size(); ++i) unit.push_back((values[i] - all_[i].low) / all_[i].range());
  return unit;
}

Parameters ParameterTable::from_unit(std::span<const double> unit) const {
  Parameters values(size());
  for (std::size_t i = 0; i < size(); ++i) values[i] = all_[i].low + unit[i] * all_[i].range();
  return values;
}

Parameters ParameterTable::from_text(const std::string& text, const std::string& where) const {
  const auto fail = [&](const std::string& problem) {
    const std::string form = joined(all_, ",", [](const ParameterInfo& info) { return info.name + "=.."; });
    throw Error(Code::setting_malformed, where, problem, "give all " + in_words(size()) + " as " + form);
  };
  Parameters parameters(size());
  std::set<std::size_t> given;
  std::istringstream stream(text);
  stream.exceptions(std::ios::badbit);  // otherwise truncation by lack of memory would look like the end
  for (std::string part; std::getline(stream, part, ',');) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos) fail("'" + part + "' is not NAME=VALUE");
    const std::string name = part.substr(0, equals), value = part.substr(equals + 1);
    std::size_t index = 0;
    while (index < size() && name != all_[index].name && name != all_[index].option) ++index;
    if (index == size()) fail("'" + name + "' is not a parameter");
    if (!given.insert(index).second) fail("gives " + name + " twice");
    parameters[index] = number_from<double>(value).value_or(NAN);
    if (!std::isfinite(parameters[index])) fail("'" + value + "' is not a number");
  }
  if (given.size() != size())
    fail("gives " + std::to_string(given.size()) + " of " + std::to_string(size()) + " parameters");
  return parameters;
}

Parameters with_conventions(Parameters values, const ParameterTable& table) {
  for (std::size_t p = 0; p < table.size(); ++p)
    if (table[p].convention) values[p] = *table[p].convention;
  return values;
}

}  // namespace decid::sim
