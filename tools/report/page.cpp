// Pages: see page.hpp. Text is escaped, so that a file's name cannot leave the block of data; and if it did, the page's
// content security policy (W3C, Content Security Policy Level 3) lets no script run except the page's own, by its
// hash.
#include "tools/report/page.hpp"

#include <utility>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "base/files/sha256.hpp"
#include "embedded/report_common_js.hpp"
#include "embedded/report_css.hpp"
#include "embedded/report_page.hpp"
#include "embedded/report_plot_js.hpp"
#include "tools/report/figures/png.hpp"

namespace decid::tools {
namespace {

// For a script element: no `<` at all, so neither `</script>` nor `<!--` can stand in it. ASCII only; bytes that are
// not UTF-8 (a file name may hold any) become U+FFFD.
std::string script_json(const Json& data) {
  const std::string text = data.dump(-1, ' ', true, Json::error_handler_t::replace);
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      escaped += "\\u003c";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

std::string detail_blocks(const std::vector<Json>& details) {
  std::string blocks;
  for (std::size_t i = 0; i < details.size(); ++i)
    blocks += "<script type=\"application/json\" id=\"details-" + std::to_string(i + 1) + "\">" +
              script_json(details[i]) + "</script>\n";
  return blocks;
}

/// Returns the name of a script in a content security policy: 'sha256-' and its hash in base 64.
std::string script_hash(std::string_view script) {
  const std::string digits = sha256(script);
  std::string bytes;
  for (std::size_t i = 0; i < digits.size(); i += 2)
    bytes += static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16));
  return "'sha256-" + base64(bytes) + "'";
}

}  // namespace

Json protocol_figures(const sim::Protocol& protocol) {
  return {{"name", protocol.name},
          {"duration_s", page_number(protocol.duration_s())},
          {"sample_rate_hz", page_number(protocol.experiment.sample_rate_hz)},
          {"amplitude_deg", page_number(sim::make_stimulus(protocol.experiment).peak_to_peak_rad() / sim::rad_per_deg)},
          {"cycle_s", page_number(protocol.experiment.cycle_s())},
          {"cycles", protocol.experiment.cycles()},
          {"lead_in_s", page_number(protocol.experiment.lead_in_s())},
          {"mass_kg", page_number(protocol.experiment.body.mass_kg)},
          {"com_height_m", page_number(protocol.experiment.body.com_height_m)},
          {"mgh", page_number(protocol.experiment.body.mgh())}};
}

std::string page_html(const Page& page, const Json& data) {
  const std::string block = script_json(data), details = detail_blocks(page.details),
                    css = std::string(embedded::report_css()) + std::string(page.style),
                    own = std::string(embedded::report_common_js()) + std::string(embedded::report_plot_js()) +
                          std::string(page.script),
                    hash = script_hash(own);
  // One pass over the page alone: inserted text is never searched for marks.
  const std::pair<std::string_view, std::string_view> parts[] = {
      {"{{script_hash}}", hash}, {"{{title}}", page.title}, {"{{css}}", css},         {"{{title}}", page.title},
      {"{{lead}}", page.lead},   {"{{data}}", block},       {"{{details}}", details}, {"{{page_js}}", own}};
  std::string html;
  std::string_view rest = embedded::report_page();
  for (const auto& [mark, content] : parts) {
    const std::size_t at = rest.find(mark);
    if (at == std::string_view::npos)
      throw Error(Code::internal, "report/page.html", "has no " + std::string(mark), "put it back");
    html += rest.substr(0, at);
    html += content;
    rest.remove_prefix(at + mark.size());
  }
  html += rest;
  return html;
}

}  // namespace decid::tools
