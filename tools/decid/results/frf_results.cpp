// Posteriors of published frequency responses as JSON, text and arrays: see frf_results.hpp.
#include "tools/decid/results/frf_results.hpp"

#include <algorithm>
#include <cmath>

#include "base/version.hpp"
#include "dataset/npz/arrays.hpp"
#include "tools/decid/results/posterior_results.hpp"
#include "tools/decid/results/results.hpp"

namespace decid::tools {
namespace {

/// A gain and a phase, with the phase within 180 degrees of another phase.
struct Polar {
  double gain, phase_deg;
};
Polar polar(sim::Complex response, double near_deg) {
  const double phase = std::arg(response) / sim::rad_per_deg;
  return {std::abs(response), phase + 360.0 * std::round((near_deg - phase) / 360.0)};
}

struct Shown {
  Polar table, model;
  double low_deg, high_deg;  // of the model's phase
};

/// Row by row, phases unwrapped from each to the next.
std::vector<Shown> shown_rows(const FrfReport& report) {
  std::vector<Shown> rows;
  double before_deg = 0.0;
  for (std::size_t i = 0; i < report.found.predicted().size(); ++i) {
    const frf::Predicted& predicted = report.found.predicted()[i];
    const Polar table = polar(report.density.table().rows[i].response, before_deg);
    const Polar model = polar(predicted.response, table.phase_deg);
    const double turned = model.phase_deg - predicted.phase_deg;
    rows.push_back({table, model, predicted.phase_low_deg + turned, predicted.phase_high_deg + turned});
    before_deg = table.phase_deg;
  }
  return rows;
}

Json table_json(const FrfReport& report) {
  Json json;
  for (const char* key : {"frequency_hz", "gain", "phase_deg", "sd", "model_gain", "model_gain_interval90",
                          "model_phase_deg", "model_phase_interval90", "distance"})
    json[key] = Json::array();
  const std::vector<Shown> rows = shown_rows(report);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const frf::Row& row = report.density.table().rows[i];
    const frf::Predicted& predicted = report.found.predicted()[i];
    json["frequency_hz"].push_back(row.frequency_hz);
    json["gain"].push_back(rows[i].table.gain);
    json["phase_deg"].push_back(rows[i].table.phase_deg);
    json["sd"].push_back(row.deviation > 0.0 ? Json(row.deviation) : Json(nullptr));
    json["model_gain"].push_back(rows[i].model.gain);
    json["model_gain_interval90"].push_back({predicted.gain_low, predicted.gain_high});
    json["model_phase_deg"].push_back(rows[i].model.phase_deg);
    json["model_phase_interval90"].push_back({rows[i].low_deg, rows[i].high_deg});
    json["distance"].push_back(predicted.distance);
  }
  return json;
}

Json diagnostics_json(const frf::Fit& found, const sim::ParameterTable& table) {
  Json json = common_diagnostics(found, table.names(), {"gain", "error"});
  json["evaluations"] = found.evaluations();
  return json;
}

sim::Parameters means(const FrfReport& report) {
  sim::Parameters made(report.density.model().protocol().parameters().size());
  for (std::size_t p = 0; p < made.size(); ++p) made[p] = report.found.mean(static_cast<int>(p));
  return made;
}

std::string headline(const FrfReport& report) {
  const frf::Table& table = report.density.table();
  std::string text = format("%s: %zu frequencies, %g to %g Hz", table.file.c_str(), table.rows.size(),
                            table.rows.front().frequency_hz, table.rows.back().frequency_hz);
  const frf::Misfit& misfit = report.found.misfit();
  if (table.has_confidence())
    text += format("; by its %s chi-square is %.3g at %d degrees of freedom, p = %.2g", table.confidence.c_str(),
                   misfit.chi_square, misfit.degrees_of_freedom, misfit.p_value);
  else
    text += ", without confidence";
  return text + "\n";
}

}  // namespace

std::string frf_fit_json(const FrfReport& report) {
  const frf::Fit& found = report.found;
  const sim::Protocol& protocol = report.density.model().protocol();
  const sim::ParameterTable& ranges = report.density.ranges();
  const frf::Table& table = report.density.table();
  const double mgh = protocol.experiment.body.mgh();
  Json parameters = parameters_json(ranges, means(report), mgh, report.truth);
  for (std::size_t p = 0; p < ranges.size(); ++p) {
    add_found(parameters[p], found, p, ranges[p], mgh);
    parameters[p]["range"] = {ranges[p].low, ranges[p].high};
    parameters[p]["prior_sd"] = found.prior_stddev(static_cast<int>(p));
    parameters[p]["contraction"] = found.contraction(static_cast<int>(p));
  }
  const Json json{{"decid", version},
                  {"options", report.options},
                  {"body", body_json(protocol.experiment.body, report.body_assumed)},
                  {"file", table.file},
                  {"protocol", protocol.name},
                  {"confidence", table.has_confidence() ? Json(table.confidence) : Json(nullptr)},
                  {"parameters", std::move(parameters)},
                  {"fit", {{"answer", "posterior"}, {"seconds", report.seconds}}},
                  {"misfit",
                   {{"chi_square", found.misfit().chi_square},
                    {"degrees_of_freedom", found.misfit().degrees_of_freedom},
                    {"p_value", number_or_null(found.misfit().p_value)}}},
                  {"gain", quantity_json(found, found.gain())},
                  {"error", quantity_json(found, found.error())},
                  {"correlations", correlations_json(found, ranges.size())},
                  {"frf", table_json(report)},
                  {"diagnostics", diagnostics_json(found, ranges)},
                  {"trust", name(trust_of(found.warnings()))},
                  {"warnings", warnings_json(found.warnings())}};
  // A file name need not be UTF-8; other bytes are replaced.
  return print_json(json) + "\n";
}

std::string frf_fit_text(const FrfReport& report) {
  const frf::Fit& found = report.found;
  const sim::Protocol& protocol = report.density.model().protocol();
  const sim::ParameterTable& ranges = report.density.ranges();
  const frf::Table& table = report.density.table();
  std::string text = headline(report) + trust_text(found.warnings());
  if (found.explained()) {
    text += table_heading("mean", "90 % of the draws", report.truth.has_value(), " contraction");
    const sim::Parameters mean = means(report);
    for (std::size_t p = 0; p < ranges.size(); ++p)
      text += parameter_line(found, p, ranges[p], mean[p], protocol.experiment.body.mgh(), report.truth,
                             format(" %11.2f", found.contraction(static_cast<int>(p))));
    text += "  contraction: fraction of the prior's variance that the table removes; at 0 the draws are the prior's\n";
  } else {
    text += "  no parameters are shown, as no controller of the model has this response; the nearest ones have:\n";
  }
  if (found.deviation(found.gain()) > 0.0)
    text += format("  the table's over the true gain %.3g +- %.2g\n", found.mean(found.gain()),
                   found.deviation(found.gain()));
  if (found.deviation(found.error()) > 0.0)
    text += format("  errors%s %.2g +- %.1g %% of the response\n",
                   table.has_confidence() ? " beyond the table's confidence" : "",
                   100.0 * found.mean(found.error()), 100.0 * found.deviation(found.error()));
  text += format("  %8s %9s %9s %20s %9s %9s %20s %9s\n", "Hz", "gain", "model", "90 % of the draws", "phase", "model",
                 "90 % of the draws", "distance");
  const std::vector<Shown> rows = shown_rows(report);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const frf::Predicted& predicted = found.predicted()[i];
    text += format("  %8.4g %9.4g %9.4g %20s %9.1f %9.1f %20s %9.1f\n", table.rows[i].frequency_hz, rows[i].table.gain,
                   rows[i].model.gain, format("%.4g to %.4g", predicted.gain_low, predicted.gain_high).c_str(),
                   rows[i].table.phase_deg, rows[i].model.phase_deg,
                   format("%.1f to %.1f", rows[i].low_deg, rows[i].high_deg).c_str(), predicted.distance);
  }
  text += format("  %d chains, %d draws worth %.0f and more, R-hat %.3f and less; %.1f s\n", found.chains(),
                 found.draws(), *std::ranges::min_element(found.effective_draws()),
                 *std::ranges::max_element(found.rhat()), report.seconds);
  return text + warnings_text(found.warnings()) + body_text(protocol.experiment.body, report.body_assumed);
}

void write_frf_draws(const std::filesystem::path& path, const FrfReport& report) {
  const frf::Fit& found = report.found;
  const std::size_t parameters = report.density.model().protocol().parameters().size();
  const auto draws = static_cast<std::size_t>(found.draws());
  std::vector<double> matrix, chain;
  for (std::size_t draw = 0; draw < draws; ++draw) {
    for (std::size_t p = 0; p < parameters; ++p) matrix.push_back(found.draws_of(static_cast<int>(p))[draw]);
    const int number = static_cast<int>(draw) / found.draws_per_chain();
    chain.push_back(number);
  }
  const std::vector<dataset::NamedArray> arrays{{"parameters", {draws, parameters}, matrix},
                                                {"gain", {draws}, found.draws_of(found.gain())},
                                                {"error", {draws}, found.draws_of(found.error())},
                                                {"chain", {draws}, chain}};
  dataset::write_arrays(path, arrays);
}

}  // namespace decid::tools
