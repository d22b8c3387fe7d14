// The comparison of methods: see comparison_page.hpp. page.cpp makes the page, comparison.js draws it.
#include "tools/report/comparison_page.hpp"

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "embedded/comparison_js.hpp"
#include "embedded/method_table_js.hpp"
#include "tools/report/json/parameters_json.hpp"
#include "tools/report/json/recording_json.hpp"
#include "tools/report/page.hpp"

namespace decid::tools {
Json comparison_json(const ComparisonFigures& figures) {
  Json methods = Json::array();
  for (const MethodFigures& method : figures.methods) {
    methods.push_back({{"name", method.name},
                       {"description", method.description},
                       {"mse", method.mse},
                       {"mse_standard_error", method.mse_standard_error},
                       {"mse_per_parameter", by_parameter(figures.protocol.parameters(), method.mse_per_parameter)},
                       {"error_per_standard_error",
                        method.error_per_standard_error ? Json(*method.error_per_standard_error) : Json(nullptr)},
                       {"simulations", method.simulations},
                       {"seconds", method.seconds}});
  }
  return {{"version", figures.version},
          {"model", figures.model},
          {"weights_sha256", figures.sha256},
          {"trials_from", figures.trials_from},
          {"protocol", figures.protocol.name},
          {"sensor_noise_deg", {figures.protocol.noise.sensor.low_deg, figures.protocol.noise.sensor.high_deg}},
          {"trials", figures.trials},
          {"threads", figures.threads},
          {"budget", figures.budget},
          {"starts", figures.starts},
          {"methods", std::move(methods)}};
}

std::string comparison_text(const ComparisonFigures& figures) {
  const sim::ParameterTable& table = figures.protocol.parameters();
  std::string text = format(
      "%d trials (%s), protocol '%s', measurement noise %g to %g degrees, %s, %d threads\n\n| method | MSE | +- |",
      figures.trials, figures.trials_from.c_str(), figures.protocol.name.c_str(), figures.protocol.noise.sensor.low_deg,
      figures.protocol.noise.sensor.high_deg, figures.model.c_str(), figures.threads);
  for (const sim::ParameterInfo& info : table) text += " " + info.name + " |";
  text += " simulations | seconds |\n|";
  for (std::size_t column = 0; column < table.size() + 5; ++column) text += "---|";
  text += "\n";
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

ComparisonFigures read_comparison(const std::string& file, const sim::Protocol& protocol) {
  const Json json = parse_json(read_file(file), file);
  try {
    ComparisonFigures figures{.version = json.at("version"),
                              .model = json.at("model"),
                              .sha256 = json.at("weights_sha256"),
                              .trials_from = json.at("trials_from"),
                              .protocol = protocol,
                              .trials = json.at("trials"),
                              .threads = json.at("threads"),
                              .budget = json.at("budget"),
                              .starts = json.at("starts"),
                              .methods = {}};
    figures.protocol.name = json.at("protocol");
    figures.protocol.noise.sensor = {json.at("sensor_noise_deg").at(0), json.at("sensor_noise_deg").at(1)};
    for (const Json& one : json.at("methods")) {
      MethodFigures& method = figures.methods.emplace_back();
      method.name = one.at("name");
      method.description = one.at("description");
      method.mse = one.at("mse");
      method.mse_standard_error = one.at("mse_standard_error");
      method.simulations = one.at("simulations");
      method.seconds = one.at("seconds");
      for (const sim::ParameterInfo& info : protocol.parameters())
        method.mse_per_parameter.push_back(one.at("mse_per_parameter").at(info.name));
      if (const Json& error = one.at("error_per_standard_error"); !error.is_null())
        method.error_per_standard_error = error.get<double>();
    }
    return figures;
  } catch (const Json::exception&) {
    throw Error(Code::file_unsupported, file, "is not a comparison of methods",
                "give the JSON file that decid compare -o wrote");
  }
}

std::string comparison_html(const ComparisonFigures& figures, const Call& call) {
  Json data = comparison_json(figures);
  data["call"] = call_json(call, figures.protocol.name);
  data["protocol"] = protocol_figures(figures.protocol);
  const std::string script = std::string(embedded::method_table_js()) + std::string(embedded::comparison_js());
  return page_html({.title = "Network, posterior and iterative fit",
                    .lead = "Ways to identify the same simulated trials, whose parameters are known.",
                    .script = script},
                   data);
}

}  // namespace decid::tools
