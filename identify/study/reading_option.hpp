// Options of reading recordings by name and text, as a sheet's cells give them.
#pragma once

#include <string>
#include <string_view>

#include "identify/recordings.hpp"

namespace decid {

/// Returns the unit of angles, or nothing for another word: "deg", "rad", "mrad".
std::optional<recording::Unit> angle_unit_named(std::string_view name);
/// Returns the metres of a unit of length, or nothing for another word: "m", "cm", "mm".
std::optional<double> metres_of_unit(std::string_view name);

/// Returns the option's name for a column of a sheet ("Tilt column": "tilt_column"), empty for any other column.
std::string find_reading_option(std::string_view column);

/// Sets an option of find_reading_option(). Letter case of words does not count; "no" is none, and "yes" of `invert` is
/// the sway. Throws Error that calls it `where` for a value that the option does not
/// have.
void set_reading_option(ReadOptions& options, const std::string& name, const std::string& value,
                        const std::string& where);

}  // namespace decid
