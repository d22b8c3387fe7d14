// Groups compared, as text.
#pragma once

#include <string>

#include "identify/result.hpp"

namespace decid::tools {

/// Returns what people read of the report's groups, without the verdicts; nothing of a report without groups.
std::string groups_text(const Report& report);
/// Returns sentences on which parameters differ between the groups; nothing of a report without groups.
std::string verdicts_text(const Report& report);

}  // namespace decid::tools
