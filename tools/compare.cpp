// The comparison of methods: see compare.hpp. tools/page.cpp makes the page, tools/report/compare.js draws it.
#include "tools/compare.hpp"

#include <cmath>

#include "embedded/compare_js.hpp"
#include "tools/page.hpp"
#include "tools/text.hpp"

namespace decid::tools {
namespace {

using json = nlohmann::ordered_json;

}  // namespace

MethodFigures errors_of(std::string name, std::string description, std::span<const sim::Parameters> estimates,
                        std::span<const sim::Parameters> truth, const sim::Parameters& deviation) {
  MethodFigures figures;
  figures.name = std::move(name);
  figures.description = std::move(description);
  const auto count = static_cast<double>(truth.size());
  double squares = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    double of_trial = 0;
    for (std::size_t p = 0; p < sim::parameter_count; ++p) {
      const double error = (estimates[i][p] - truth[i][p]) / deviation[p];
      figures.mse_per_parameter[p] += error * error / count;
      of_trial += error * error / static_cast<double>(sim::parameter_count);
    }
    figures.mse += of_trial / count;
    squares += of_trial * of_trial / count;
  }
  if (truth.size() > 1)
    figures.mse_standard_error = std::sqrt(std::max(0.0, squares - figures.mse * figures.mse) / (count - 1));
  return figures;
}

json comparison_json(const ComparisonFigures& figures) {
  json methods = json::array();
  for (const MethodFigures& method : figures.methods) {
    json per_parameter;
    for (std::size_t p = 0; p < sim::parameter_count; ++p)
      per_parameter[sim::parameter_info[p].name] = method.mse_per_parameter[p];
    methods.push_back({{"name", method.name},
                       {"description", method.description},
                       {"mse", method.mse},
                       {"mse_standard_error", method.mse_standard_error},
                       {"mse_per_parameter", std::move(per_parameter)},
                       {"error_per_standard_error",
                        method.error_per_standard_error ? json(*method.error_per_standard_error) : json(nullptr)},
                       {"simulations", method.simulations},
                       {"seconds", method.seconds}});
  }
  return {{"version", figures.version},
          {"model", figures.model},
          {"trials_from", figures.trials_from},
          {"protocol", figures.protocol.name},
          {"sensor_noise_deg", {figures.protocol.sensor_noise.low_deg, figures.protocol.sensor_noise.high_deg}},
          {"trials", figures.trials},
          {"threads", figures.threads},
          {"budget", figures.budget},
          {"starts", figures.starts},
          {"methods", std::move(methods)}};
}

std::string comparison_text(const ComparisonFigures& figures) {
  const sim::SensorNoise& noise = figures.protocol.sensor_noise;
  std::string text = format(
      "%d trials (%s), protocol '%s', sensor noise %g to %g degrees, %s, %d threads\n\n"
      "| method | MSE | +- |",
      figures.trials, figures.trials_from.c_str(), figures.protocol.name.c_str(), noise.low_deg, noise.high_deg,
      figures.model.c_str(), figures.threads);
  for (const sim::ParameterInfo& info : sim::parameter_info) text += format(" %s |", info.name);
  text += " simulations | seconds |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const MethodFigures& method : figures.methods) {
    text += format("| %s | %.3f | %.3f |", method.name.c_str(), method.mse, method.mse_standard_error);
    for (const double mse : method.mse_per_parameter) text += format(" %.3f |", mse);
    text += format(" %.0f | %.2g |\n", method.simulations, method.seconds);
  }
  text += "\n";
  for (const MethodFigures& method : figures.methods)
    if (method.error_per_standard_error)
      text += format("%s: errors are %.2f times the standard errors (root mean square)\n", method.name.c_str(),
                     *method.error_per_standard_error);
  return text;
}

std::string comparison_html(const ComparisonFigures& figures) {
  json data = comparison_json(figures);
  data["protocol"] = protocol_figures(figures.protocol);
  return page_html({.title = "Network and iterative fit",
                    .lead = "Three ways to identify the same simulated trials, whose parameters are known.",
                    .script = embedded::compare_js()},
                   data);
}

}  // namespace decid::tools
