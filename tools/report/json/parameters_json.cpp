// Parameters as JSON: see parameters_json.hpp.
#include "tools/report/json/parameters_json.hpp"

#include <cmath>

namespace decid::tools {

Json number_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json text_or_null(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

Json page_number(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0.0) return 0.0;
  const double scale = std::pow(10.0, 5.0 - std::floor(std::log10(std::abs(value))));
  return std::isfinite(scale) ? std::round(value * scale) / scale : value;
}

Json parameters_json(const sim::ParameterTable& table, const sim::Parameters& parameters, double mgh,
                     const std::optional<sim::Parameters>& truth, Json (*number)(double)) {
  Json list = Json::array();
  for (std::size_t p = 0; p < table.size(); ++p) {
    const sim::ParameterInfo& info = table[p];
    Json parameter{{"name", info.name}, {"value", number(parameters[p])}, {"unit", info.unit}};
    parameter["normalized"] = info.scales_with_mgh ? number(parameters[p] / mgh) : Json(nullptr);
    if (truth) parameter["true"] = number((*truth)[p]);
    list.push_back(std::move(parameter));
  }
  return list;
}

Json evaluation_json(const sim::ParameterTable& table, const Evaluation& evaluation) {
  return {{"mse", evaluation.mse()},
          {"matlab_loss", evaluation.matlab_loss()},
          {"mse_per_parameter", by_parameter(table, evaluation.mse_per_parameter)},
          {"trials", evaluation.trials}};
}

Json warnings_json(const Warnings& warnings) {
  Json list = Json::array();
  for (const Warning& w : warnings)
    list.push_back({{"code", w.code}, {"severity", name(w.severity)}, {"text", w.text}});
  return list;
}

}  // namespace decid::tools
