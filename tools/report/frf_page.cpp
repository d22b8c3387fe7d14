// The page of a frequency response's fit: see frf_page.hpp. frf_fit.js draws it.
#include "tools/report/frf_page.hpp"

#include "base/version.hpp"
#include "embedded/frf_fit_js.hpp"
#include "embedded/parameters_js.hpp"
#include "embedded/responses_js.hpp"
#include "sim/body_model.hpp"
#include "tools/report/json/recording_json.hpp"
#include "tools/report/page.hpp"

namespace decid::tools {
namespace {

/// Adds the meaning of each parameter to a controller's answer.
void describe_parameters(Json& answer) {
  if (!answer.contains("parameters")) return;
  const sim::BodyModel& controller = sim::find_body_model(answer.at("controller"), "controller");
  for (std::size_t p = 0; p < controller.parameters.size(); ++p)
    answer["parameters"][p]["description"] = controller.parameters[p].description;
}

}  // namespace

std::string frf_page(Json answer, const Call& call) {
  answer["decid"] = version;
  answer["call"] = call_json(call, answer.at("protocol"));
  answer["fit"].erase("seconds");
  describe_parameters(answer);
  if (answer.contains("controllers"))
    for (Json& other : answer["controllers"]) describe_parameters(other);
  return page_html({.title = "Frequency response",
                    .lead = "Controllers that have a published frequency response, and the ranges of their parameters.",
                    .script = std::string(embedded::parameters_js()) + std::string(embedded::responses_js()) +
                              std::string(embedded::frf_fit_js())},
                   answer);
}

}  // namespace decid::tools
