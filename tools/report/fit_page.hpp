// The report of `decid fit --report`: one self-contained HTML page that opens offline, drawn as SVG.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/files/json_object.hpp"
#include "identify/fit_recordings.hpp"
#include "tools/report/other_answer.hpp"

namespace decid::tools {

/// What the page shows of a recording; ranges: those of the density.
Json fit_page_recording(const Identification& recording, const FitFigures& fitted, const Identifications& of,
                        const sim::ParameterTable& ranges);

/// The page of such recordings and of the errors of others; request: what was asked for; other_answer: what
/// the network would add, if it knows the experiment. Every string from outside
/// (file names, warnings) is escaped. Deterministic: no dates, no random ids.
std::string fit_report_html(const std::string& version, const FitRequest& request, std::vector<Json> recordings,
                            const std::vector<std::string>& failed, const Json& groups,
                            const std::optional<OtherAnswer>& other_answer);

}  // namespace decid::tools
