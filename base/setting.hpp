// Names of settings in messages, and their limits. Python and Octave use "fill_gaps"; a program uses its own option's
// name, and C its field's (bindings/c/error.cpp).
#pragma once

#include <string>
#include <string_view>

namespace decid {

/// Returns the name of a setting for messages: the name itself, or the result of the function given to name_settings().
std::string setting(std::string_view name);

/// Makes later messages name settings by the result of `called`; nullptr: by their own names. A program with options
/// calls this once, before any other function of the library.
void name_settings(std::string (*called)(std::string_view name));

/// Throws Error, naming `where`, if the value of a setting is below `least`.
void require_at_least(const std::string& where, int value, int least);

}  // namespace decid
