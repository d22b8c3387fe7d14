// Warnings about a result: assumptions, suspicious data, and reasons not to use it.
#pragma once

#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace decid {

/// info: an assumption or a step, as intended; caution: the result may be wrong; invalid: the result must not be used
/// without an examination.
enum class Severity { info, caution, invalid };
/// Returns "info", "caution", "invalid".
const char* name(Severity severity);

struct Warning {
  Severity severity;
  std::string code;  ///< for scripts, stable: docs/guide/warnings.md lists them
  std::string text;  ///< for users, a sentence or a few
  bool operator==(const Warning&) const = default;
};
using Warnings = std::vector<Warning>;

inline void add_warning(Warnings& warnings, Severity severity, std::string code, std::string text) {
  warnings.push_back({severity, std::move(code), std::move(text)});
}
inline void add_info(Warnings& warnings, std::string code, std::string text) {
  add_warning(warnings, Severity::info, std::move(code), std::move(text));
}
inline void add_caution(Warnings& warnings, std::string code, std::string text) {
  add_warning(warnings, Severity::caution, std::move(code), std::move(text));
}
inline void add_invalid(Warnings& warnings, std::string code, std::string text) {
  add_warning(warnings, Severity::invalid, std::move(code), std::move(text));
}
/// Adds `more` behind the warnings.
inline void append(Warnings& warnings, Warnings more) {
  warnings.insert(warnings.end(), std::move_iterator(more.begin()), std::move_iterator(more.end()));
}

/// Returns true if one of the warnings has this code.
bool has_code(const Warnings& warnings, std::string_view code);

/// Returns the first of the most severe warnings; the end if there are none.
Warnings::const_iterator most_severe(const Warnings& warnings);

/// The usability of a result, by its most severe warning.
enum class Trust { usable, caution, not_usable };
/// Returns the usability of a result with these warnings: usable without any caution.
Trust worst_trust(const Warnings& warnings);
/// Returns "usable", "caution", "not usable".
const char* name(Trust trust);

}  // namespace decid
