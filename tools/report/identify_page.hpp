// The report of `decid identify --report`: one self-contained HTML page that opens offline.
#pragma once

#include <string>

#include "identify/result.hpp"

namespace decid::tools {

/// Returns the page. Every string from outside (file names, warnings) is escaped. Deterministic: no dates, no random
/// ids.
std::string identify_page(const Report& report);

}  // namespace decid::tools
