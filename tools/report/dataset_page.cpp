// The report of a data set: see dataset_page.hpp. page.cpp makes the page, dataset.js draws it.
#include "tools/report/dataset_page.hpp"

#include "base/files/json_object.hpp"
#include "embedded/dataset_js.hpp"
#include "tools/report/json/recording_json.hpp"
#include "tools/report/page.hpp"

namespace decid::tools {
namespace {

using dataset::Distribution;

Json figures_of(const Distribution& values) {
  return {{"mean", values.mean()},
          {"sd", values.stddev()},
          {"min", values.min()},
          {"max", values.max()},
          {"counts", std::vector<long long>(values.bins().begin(), values.bins().end())}};
}

Json distribution(const std::string& description, const std::string& unit, const Distribution& base,
                  const Distribution& enriched) {
  return {{"description", description}, {"unit", unit},
          {"low", base.low()},          {"high", base.high()},
          {"base", figures_of(base)},   {"enriched", figures_of(enriched)}};
}

Json rate(long long valid, long long attempts) {
  if (attempts == 0) return nullptr;
  return static_cast<double>(valid) / static_cast<double>(attempts);
}

}  // namespace

Json dataset_json(const DatasetFigures& figures) {
  const dataset::DatasetReport& report = figures.report;
  const long long base = report.base.peak_to_peak.count(), trials = report.all.peak_to_peak.count();
  Json distributions;
  const sim::ParameterTable& table = figures.request.protocol.parameters();
  for (std::size_t i = 0; i < table.size(); ++i) {
    const sim::ParameterInfo& info = table[i];
    distributions[info.name] =
        distribution(info.description, info.unit, report.base.parameters[i], report.all.parameters[i]);
  }
  distributions["peak_to_peak"] =
      distribution("Peak-to-peak sway", "rad", report.base.peak_to_peak, report.all.peak_to_peak);
  Json json{{"file", figures.file},
            {"bytes", figures.bytes},
            {"sha256", figures.sha256},
            {"trials", trials},
            {"base_trials", base},
            {"children", trials - base},
            {"samples", figures.request.protocol.samples()},
            {"seed", figures.request.seed},
            {"protocol", figures.request.protocol.name},
            {"base_attempts", report.base_attempts},
            {"acceptance_rate", rate(base, report.base_attempts)},
            {"parents", report.parents},
            {"parent_threshold_rad", dataset::parent_peak_to_peak_rad},
            {"child_attempts", report.child_attempts},
            {"child_acceptance_rate", rate(trials - base, report.child_attempts)},
            {"distributions", std::move(distributions)}};
  add_call(json, figures.call);
  return json;
}

std::string dataset_html(const DatasetFigures& figures) {
  Json data = dataset_json(figures);
  data["version"] = figures.version;
  data["call"] = call_json(figures.call, figures.request.protocol.name);
  data["protocol"] = protocol_figures(figures.request.protocol);
  return page_html({.title = "Data set report",
                    .lead = "Simulated trials of the DEC posture-control model with known parameters.",
                    .script = embedded::dataset_js()},
                   data);
}

}  // namespace decid::tools
