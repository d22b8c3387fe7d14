// The report of `decid fit --report`: one self-contained HTML page that opens offline, drawn as SVG.
#pragma once

#include <string>

#include "identify/result.hpp"

namespace decid::tools {

/// Returns the page of a report of fits. Every string from outside (file names, warnings) is escaped. Deterministic: no
/// dates, no random ids.
std::string fit_page(const Report& report);

}  // namespace decid::tools
