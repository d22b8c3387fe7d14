// The report of `decid fit --report`: one self-contained HTML page that opens offline, drawn as SVG.
#pragma once

#include <string>

#include "identify/fit_recordings.hpp"

namespace decid::tools {

/// The page; request: what was asked for. Every string from outside (file names, warnings) is escaped. Deterministic:
/// no dates, no random ids.
std::string fit_report_html(const std::string& version, const FitRequest& request, const FittedRecordings& all);

}  // namespace decid::tools
