// What people should know of a result: what was assumed, what looks odd, what makes it void.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace decid {

/// info: what was assumed or done, as it should be; caution: the result may be off; invalid: it is not to be used
/// unless somebody has looked into it.
enum class Severity { info, caution, invalid };
/// "info", "caution", "invalid".
const char* name(Severity severity);

struct Warning {
  Severity severity;
  std::string code;  ///< for scripts, stable: docs/guide/warnings.md lists them
  std::string text;  ///< for people, one sentence
  bool operator==(const Warning&) const = default;
};
using Warnings = std::vector<Warning>;

inline void add_info(Warnings& warnings, std::string code, std::string text) {
  warnings.push_back({Severity::info, std::move(code), std::move(text)});
}
inline void add_caution(Warnings& warnings, std::string code, std::string text) {
  warnings.push_back({Severity::caution, std::move(code), std::move(text)});
}
inline void add_invalid(Warnings& warnings, std::string code, std::string text) {
  warnings.push_back({Severity::invalid, std::move(code), std::move(text)});
}

/// The first of the gravest; the end if there are none.
Warnings::const_iterator gravest(const Warnings& warnings);

/// What warnings leave of a result: as the gravest of them says.
enum class Trust { usable, caution, not_usable };
Trust trust_of(const Warnings& warnings);
/// "usable", "caution", "not usable".
const char* name(Trust trust);

}  // namespace decid
