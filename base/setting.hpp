// How messages name a setting. C, Python and Octave call one "fill_gaps"; a program calls it as its own options are
// called.
#pragma once

#include <string>
#include <string_view>

namespace decid {

/// Returns what a message calls the setting of this name: the name itself, or what name_settings() was given makes of
/// it.
std::string setting(std::string_view name);

/// Has every later message call settings by what `called` returns. For a program with options of its own, once, before
/// it calls anything else of the library; nullptr: by their names.
void name_settings(std::string (*called)(std::string_view name));

}  // namespace decid
