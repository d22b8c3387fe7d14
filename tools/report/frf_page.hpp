// The page of `decid fit --frf`: each controller's response with its 90% band over the table, its parameters, and the
// comparison of the controllers, in one HTML file that opens offline.
#pragma once

#include <string>

#include "base/files/json_object.hpp"
#include "identify/result.hpp"

namespace decid::tools {

/// Returns the page of frf_fit_object() and the call that computed it. Deterministic: leaves the time out; file names
/// are escaped.
std::string frf_page(Json answer, const Call& call);

}  // namespace decid::tools
