// Parts of the HTML pages that decid writes: data in a script block, and a page made of its template.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace decid::tools {

/// Six significant digits, null if not finite: JSON has no NaN.
nlohmann::ordered_json rounded(double value);

/// For a script element: no `<` at all, so neither `</script>` nor `<!--` can stand in it. ASCII only; bytes that are
/// not UTF-8 (a file name may hold any) become U+FFFD.
std::string script_json(const nlohmann::ordered_json& data);

/// The template with each mark, in the order they stand in it, replaced by its content. Throws Error for a missing
/// mark.
std::string fill_page(std::string_view page, const std::vector<std::pair<std::string_view, std::string>>& parts);

}  // namespace decid::tools
