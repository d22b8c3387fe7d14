// Values of a controller's parameters as options give them: NAME=VALUE, in SI units or per cent.
#pragma once

#include <string>
#include <vector>

#include "sim/parameters.hpp"

namespace decid::tools {

/// Sets values from texts NAME=VALUE; per cent are of `reference`. Returns which were given; `percent`, unless null,
/// gets which of them are per cent. Throws Error that names the option for another text, an unknown name and a name
/// that is given twice.
std::vector<bool> read_named_values(const std::string& option, const std::vector<std::string>& texts,
                                    const sim::ParameterTable& table, const sim::Parameters& reference,
                                    sim::Parameters& values, std::vector<bool>* percent = nullptr);

}  // namespace decid::tools
