// Self-contained HTML pages that open offline: what all reports share.
// A page is its data as a JSON block and a script that draws it: tools/report/page/common.js, plot.js for charts as
// SVG, and the page's own.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/files/json_object.hpp"
#include "sim/protocol/protocol.hpp"
#include "tools/report/json/parameters_json.hpp"

namespace decid::tools {

/// The page's own texts, as HTML, and its script.
struct Page {
  std::string_view title, lead, script;
  std::string_view style = {};  ///< added to page.css
  /// The details of each recording, which only its part of the page shows. Each is a separate block, which the page
  /// reads when the user opens that part. `data` has the rest, for tables of all recordings.
  std::vector<Json> details = {};
};

/// Returns the page. Escapes every string in `data`. Deterministic: no dates, no random ids.
std::string page_html(const Page& page, const Json& data);

/// Returns the figures of a protocol that pages show.
Json protocol_figures(const sim::Protocol& protocol);

}  // namespace decid::tools
