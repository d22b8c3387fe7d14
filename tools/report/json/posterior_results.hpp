// Formats a distribution for JSON and text: a network's, or a posterior of recordings or of published frequency
// responses. Found: a type with mean(), stddev(), quantile() and correlation() of its quantities, by number; the
// parameters come first.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "sim/parameters.hpp"
#include "sim/protocol/experiment.hpp"
#include "tools/report/json/parameters_json.hpp"

namespace decid::tools {

/// Returns the limits of the central interval with this probability, over a divisor.
template <class Found>
Json interval(const Found& found, int quantity, double probability, double divisor = 1.0) {
  const double tail = 0.5 * (1.0 - probability);
  return {found.quantile(quantity, tail) / divisor, found.quantile(quantity, 1.0 - tail) / divisor};
}

template <class Found>
Json quantity_json(const Found& found, int quantity) {
  return {{"value", found.mean(quantity)},
          {"sd", found.stddev(quantity)},
          {"interval50", interval(found, quantity, 0.5)},
          {"interval90", interval(found, quantity, 0.9)}};
}

/// Adds the standard deviation and the intervals to a parameter's object.
template <class Found>
void add_found(Json& parameter, const Found& found, std::size_t p, const sim::ParameterInfo& info, double mgh) {
  const int quantity = static_cast<int>(p);
  parameter["sd"] = found.stddev(quantity);
  parameter["interval50"] = interval(found, quantity, 0.5);
  parameter["interval90"] = interval(found, quantity, 0.9);
  parameter["normalized_interval90"] = info.scales_with_mgh ? interval(found, quantity, 0.9, mgh) : Json(nullptr);
}

/// Returns the correlations of the parameters, row by row.
template <class Found>
Json correlations_json(const Found& found, std::size_t parameters) {
  Json rows = Json::array();
  for (std::size_t a = 0; a < parameters; ++a) {
    Json& row = rows.emplace_back(Json::array());
    for (std::size_t b = 0; b < parameters; ++b)
      row.push_back(found.correlation(static_cast<int>(a), static_cast<int>(b)));
  }
  return rows;
}

/// Returns the diagnostics that all samplers have. names: the parameters' names; `others`: names of the quantities
/// behind them.
template <class Found>
Json common_diagnostics(const Found& found, std::vector<std::string> names, std::initializer_list<const char*> others) {
  names.insert(names.end(), others.begin(), others.end());
  Json rhat, effective;
  for (std::size_t i = 0; i < names.size(); ++i) {
    rhat[names[i]] = number_or_null(found.rhat()[i]);
    effective[names[i]] = number_or_null(found.effective_draws()[i]);
  }
  return {{"rhat", std::move(rhat)},  {"effective_draws", std::move(effective)},
          {"agreed", found.agreed()}, {"chains", found.chains()},
          {"draws", found.draws()},   {"acceptance", found.acceptance()}};
}

/// Returns a parameter as people know it: "Tilt-speed threshold (theta)".
inline std::string shown_name(const sim::ParameterInfo& info) {
  return info.description + " (" + info.name + ")";
}

/// Returns the width of the longest shown_name() of a table.
inline int name_width(const sim::ParameterTable& table) {
  std::size_t width = 0;
  for (const sim::ParameterInfo& info : table) width = std::max(width, shown_name(info).size());
  return static_cast<int>(width);
}

/// Returns a value relative to gravity, in degrees per second or in milliseconds; empty for a plain number.
inline std::string in_other_unit(const sim::ParameterInfo& info, double value, double mgh) {
  if (info.scales_with_mgh) return format(info.unit == "N m/rad" ? "%.3f m g h" : "%.3f s m g h", value / mgh);
  if (info.unit == "rad/s") return format("%.3f deg/s", value / sim::rad_per_deg);
  return info.unit == "s" ? format("%.0f ms", 1e3 * value) : std::string();
}

/// Returns the heading of parameter_line()s. width: name_width() of their table; value: the heading of the parameter's
/// value; note: the heading of parameter_line()'s note.
inline std::string table_heading(int width, const char* value, bool truth, const std::string& note = {}) {
  return format("  %-*s %10s %10s %24s %-10s %14s%s%s  %s\n", width, "", value, "sd", "90% interval", "unit", "or",
                truth ? "       true" : "", note.c_str(), "model's limits");
}

/// Returns a table's line of one parameter, which has neither sd nor interval if it is fixed, up to its limits; `value`
/// is the parameter's value, `note` comes before the limits.
template <class Found>
std::string parameter_line(const Found& found, std::size_t p, const sim::ParameterTable& table, double value,
                           double mgh, const std::optional<sim::Parameters>& truth, const std::string& note = {}) {
  const sim::ParameterInfo& info = table[p];
  const int quantity = static_cast<int>(p);
  const double low = found.quantile(quantity, 0.05), high = found.quantile(quantity, 0.95);
  const bool fixed = !(low < high);
  const std::string spread = fixed ? "fixed" : format("%.3g", found.stddev(quantity)),
                    between = fixed ? "-" : format("%.5g to %.5g", low, high);
  std::string text =
      format("  %-*s %10.5g %10s %24s %-10s %14s", name_width(table), shown_name(info).c_str(), value, spread.c_str(),
             between.c_str(), info.shown_unit().c_str(), in_other_unit(info, value, mgh).c_str());
  if (truth) text += format(" %10.5g", (*truth)[p]);
  return text + note + format("  %g to %g\n", info.low, info.high);
}

}  // namespace decid::tools
