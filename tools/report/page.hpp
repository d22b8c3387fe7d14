// Self-contained HTML pages that open offline: what all reports share.
// A page is its data as a JSON block and a script that draws it: tools/report/page/common.js, plot.js for charts as
// SVG, and the page's own.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/files/json_object.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::tools {

/// The page's own texts, as HTML, and its script.
struct Page {
  std::string_view title, lead, script;
  std::string_view style = {};  ///< added to page.css
  /// Of each recording what its part of the page alone shows: a block of its own, which is read when that is opened.
  /// The rest, for tables of all recordings, is in `data`.
  std::vector<Json> details = {};
};

/// Every string in `data` is escaped. Deterministic: no dates, no random ids.
std::string page_html(const Page& page, const Json& data);

/// Six significant digits, null if not finite: JSON has no NaN.
Json page_number(double value);

/// What pages say about a protocol.
Json protocol_figures(const sim::Protocol& protocol);

}  // namespace decid::tools
