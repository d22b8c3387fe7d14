// Parts of the HTML pages: see page.hpp.
#include "tools/page.hpp"

#include <cmath>

#include "base/error.hpp"

namespace decid::tools {

nlohmann::ordered_json rounded(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0.0) return 0.0;
  const double scale = std::pow(10.0, 5.0 - std::floor(std::log10(std::abs(value))));
  return std::isfinite(scale) ? std::round(value * scale) / scale : value;
}

std::string script_json(const nlohmann::ordered_json& data) {
  const std::string text = data.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
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

std::string fill_page(std::string_view page, const std::vector<std::pair<std::string_view, std::string>>& parts) {
  // One pass over the template alone: what is put in is never searched for marks.
  std::string filled;
  for (const auto& [mark, content] : parts) {
    const std::size_t at = page.find(mark);
    if (at == std::string_view::npos) throw Error("page template", "has no " + std::string(mark), "put it back");
    filled += page.substr(0, at);
    filled += content;
    page.remove_prefix(at + mark.size());
  }
  filled += page;
  return filled;
}

}  // namespace decid::tools
