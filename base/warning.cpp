// Warnings about a result: see warning.hpp.
#include "base/warning.hpp"

#include <algorithm>

namespace decid {

const char* name(Severity severity) {
  switch (severity) {
    case Severity::info:
      return "info";
    case Severity::caution:
      return "caution";
    case Severity::invalid:
      return "invalid";
  }
  return "";
}

bool has_code(const Warnings& warnings, std::string_view code) {
  return std::ranges::find(warnings, code, &Warning::code) != warnings.end();
}

Warnings::const_iterator most_severe(const Warnings& warnings) {
  return std::ranges::max_element(warnings, {}, &Warning::severity);
}

Trust worst_trust(const Warnings& warnings) {
  const Severity severity = warnings.empty() ? Severity::info : most_severe(warnings)->severity;
  return severity == Severity::invalid   ? Trust::not_usable
         : severity == Severity::caution ? Trust::caution
                                         : Trust::usable;
}

const char* name(Trust trust) {
  switch (trust) {
    case Trust::usable:
      return "usable";
    case Trust::caution:
      return "caution";
    case Trust::not_usable:
      return "not usable";
  }
  return "";
}

}  // namespace decid
