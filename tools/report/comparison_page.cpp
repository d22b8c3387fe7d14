// The comparison of methods: see comparison_page.hpp. page.cpp makes the page, comparison.js draws it.
#include "tools/report/comparison_page.hpp"

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "embedded/comparison_js.hpp"
#include "embedded/method_table_js.hpp"
#include "tools/report/page.hpp"
#include "tools/report/parameters_json.hpp"

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

std::string comparison_text(const Json& comparison, const sim::ParameterTable& table) {
  const Json& noise = comparison.at("sensor_noise_deg");
  std::string text =
      format("%d trials (%s), protocol '%s', sensor noise %g to %g degrees, %s, %d threads\n\n| method | MSE | +- |",
             comparison.at("trials").get<int>(), comparison.at("trials_from").get<std::string>().c_str(),
             comparison.at("protocol").get<std::string>().c_str(), noise.at(0).get<double>(), noise.at(1).get<double>(),
             comparison.at("model").get<std::string>().c_str(), comparison.at("threads").get<int>());
  for (const sim::ParameterInfo& info : table) text += " " + info.name + " |";
  text += " simulations | seconds |\n|";
  for (std::size_t column = 0; column < table.size() + 5; ++column) text += "---|";
  text += "\n";
  for (const Json& method : comparison.at("methods")) {
    text += format("| %s | %.3f | %.3f |", method.at("name").get<std::string>().c_str(), method.at("mse").get<double>(),
                   method.at("mse_standard_error").get<double>());
    for (const sim::ParameterInfo& info : table)
      text += format(" %.3f |", method.at("mse_per_parameter").at(info.name).get<double>());
    text += format(" %.0f | %.2g |\n", method.at("simulations").get<double>(), method.at("seconds").get<double>());
  }
  text += "\n";
  for (const Json& method : comparison.at("methods"))
    if (!method.at("error_per_standard_error").is_null())
      text += format("%s: errors are %.2f times the standard errors (root mean square)\n",
                     method.at("name").get<std::string>().c_str(), method.at("error_per_standard_error").get<double>());
  return text;
}

Json read_comparison(const std::string& file, const sim::ParameterTable& table) {
  const char* advice = "give the JSON file that decid compare -o wrote";
  Json comparison = parse_json(read_file(file), file);
  try {
    comparison_text(comparison, table);
    for (const char* key : {"weights_sha256", "version"}) comparison.at(key).get<std::string>();
    for (const char* key : {"budget", "starts"}) comparison.at(key).get<long long>();
    for (const Json& method : comparison.at("methods")) method.at("description").get<std::string>();
  } catch (const Json::exception&) {
    throw Error(file, "is not a comparison of methods", advice);
  }
  return comparison;
}

std::string comparison_html(const ComparisonFigures& figures) {
  Json data = comparison_json(figures);
  data["protocol"] = protocol_figures(figures.protocol);
  const std::string script = std::string(embedded::method_table_js()) + std::string(embedded::comparison_js());
  return page_html({.title = "Network, posterior and iterative fit",
                    .lead = "Ways to identify the same simulated trials, whose parameters are known.",
                    .script = script},
                   data);
}

}  // namespace decid::tools
