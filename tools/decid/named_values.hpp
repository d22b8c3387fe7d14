// Values of a controller's parameters as options give them: NAME=VALUE, in SI units or per cent, and NAME/mgh=VALUE,
// over the body's m g h.
#pragma once

#include <string>
#include <vector>

#include "sim/parameters.hpp"

namespace decid::tools {

/// Sets values from texts NAME=VALUE, in SI units; per cent are of `reference`. Returns which were given; `percent`,
/// unless null, gets which of them are per cent. Throws Error that names the option for another text, an unknown name,
/// a name that is given twice, and /mgh in a name of a parameter that does not scale with m g h, or beside per cent.
std::vector<bool> read_named_values(const std::string& option, const std::vector<std::string>& texts,
                                    const sim::ParameterTable& table, double mgh_nm_rad,
                                    const sim::Parameters& reference, sim::Parameters& values,
                                    std::vector<bool>* percent = nullptr);

}  // namespace decid::tools
