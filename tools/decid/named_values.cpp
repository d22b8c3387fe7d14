// Values of parameters as options give them: see named_values.hpp.
#include "tools/decid/named_values.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "base/error.hpp"
#include "base/number.hpp"
#include "tools/decid/prior_texts.hpp"

namespace decid::tools {
namespace {

/// A number, or per cent of a reference.
double number_of(const std::string& option, const std::string& text, double reference) {
  const bool is_percent = text.ends_with('%');
  const std::optional<double> value =
      number_from<double>(std::string_view(text).substr(0, text.size() - (is_percent ? 1 : 0)));
  if (!value || !std::isfinite(*value))
    throw Error(Code::setting_malformed, option, "'" + text + "' is not a number",
                "give a number, or a percentage such as -15%");
  return is_percent ? 0.01 * *value * reference : *value;
}

}  // namespace

std::vector<bool> read_named_values(const std::string& option, const std::vector<std::string>& texts,
                                    const sim::ParameterTable& table, double mgh_nm_rad,
                                    const sim::Parameters& reference, sim::Parameters& values,
                                    std::vector<bool>* percent) {
  std::vector<bool> given(table.size(), false);
  if (percent != nullptr) percent->assign(table.size(), false);
  for (const std::string& text : texts) {
    const NamedText named(text);
    const std::string& name = named.name.parameter;
    const auto info = std::ranges::find_if(
        table, [&](const sim::ParameterInfo& one) { return one.name == name || one.option == name; });
    if (!named.value || info == table.end())
      throw Error(Code::setting_unknown, option, "'" + text + "' names no parameter",
                  "give NAME=VALUE, such as delay=0.02 or Kp=-15%");
    const auto p = static_cast<std::size_t>(std::distance(table.begin(), info));
    if (given[p]) throw Error(Code::setting_conflict, option, "gives " + info->name + " twice", "give it once");
    if (named.name.over_mgh && (!info->scales_with_mgh || text.ends_with('%')))
      throw Error(Code::setting_conflict, option,
                  "'" + text + "' is over m g h, but " +
                      (text.ends_with('%') ? "per cent are of the mean" : info->name + " does not scale with it"),
                  "leave out /mgh");
    values[p] = (named.name.over_mgh ? mgh_nm_rad : 1.0) * number_of(option, *named.value, reference[p]);
    given[p] = true;
    if (percent != nullptr) (*percent)[p] = text.ends_with('%');
  }
  return given;
}

}  // namespace decid::tools
