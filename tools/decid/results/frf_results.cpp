// Posteriors of published frequency responses as JSON, text and arrays: see frf_results.hpp.
#include "tools/decid/results/frf_results.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <initializer_list>

#include "dataset/npz/arrays.hpp"
#include "identify/body_warnings.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/json/posterior_results.hpp"

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
  double frequency_hz;
  Polar table, model;
};

/// Row by row, phases unwrapped from each to the next. response: of a value of `found`.
template <class Found, class Response = std::identity>
std::vector<Shown> shown_rows(const frf::Table& table, const std::vector<Found>& found, Response response = {}) {
  std::vector<Shown> rows;
  double before_deg = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Polar given = polar(table.rows[i].response, before_deg);
    rows.push_back({table.rows[i].frequency_hz, given, polar(std::invoke(response, found[i]), given.phase_deg)});
    before_deg = given.phase_deg;
  }
  return rows;
}

/// Returns lists under these keys, and fills those of both kinds of answers.
Json rows_json(const std::vector<Shown>& rows, std::initializer_list<const char*> keys) {
  Json json;
  for (const char* key : keys) json[key] = Json::array();
  for (const Shown& row : rows) {
    json["frequency_hz"].push_back(row.frequency_hz);
    json["gain"].push_back(row.table.gain);
    json["phase_deg"].push_back(row.table.phase_deg);
    json["model_gain"].push_back(row.model.gain);
    json["model_phase_deg"].push_back(row.model.phase_deg);
  }
  return json;
}

std::vector<Shown> shown_rows(const FrfAnswer& answer) {
  return shown_rows(answer.density.table(), answer.found.predicted(), &frf::Predicted::response);
}

/// Returns the interval of a predicted phase, as its row shows the phase.
std::array<double, 2> phase_interval(const Shown& row, const frf::Predicted& predicted) {
  const double turned = row.model.phase_deg - predicted.phase_deg;
  return {predicted.phase_low_deg + turned, predicted.phase_high_deg + turned};
}

Json table_json(const FrfAnswer& answer) {
  const std::vector<Shown> rows = shown_rows(answer);
  Json json = rows_json(rows, {"frequency_hz", "gain", "phase_deg", "sd", "model_gain", "model_gain_interval90",
                               "model_phase_deg", "model_phase_interval90", "distance"});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double sd = answer.density.table().rows[i].stddev;
    const frf::Predicted& predicted = answer.found.predicted()[i];
    json["sd"].push_back(sd > 0.0 ? Json(sd) : Json(nullptr));
    json["model_gain_interval90"].push_back({predicted.gain_low, predicted.gain_high});
    json["model_phase_interval90"].push_back(phase_interval(rows[i], predicted));
    json["distance"].push_back(predicted.distance);
  }
  return json;
}

Json diagnostics_json(const frf::Fit& found, const sim::ParameterTable& table) {
  Json json = common_diagnostics(found, table.names(), {"gain", "error"});
  json["evaluations"] = found.evaluations();
  return json;
}

sim::Parameters means(const FrfAnswer& answer) {
  sim::Parameters made(answer.density.ranges().size());
  for (std::size_t p = 0; p < made.size(); ++p) made[p] = answer.found.mean(static_cast<int>(p));
  return made;
}

const sim::Body& body_of(const frf::Density& density) {
  return density.model().protocol().experiment.body;
}

double mgh_of(const frf::Density& density) {
  return body_of(density).mgh();
}

Json prior_json(const frf::Density& density, const std::string& name) {
  const auto& priors = density.priors().parameters;
  const auto prior = std::ranges::find(priors, name, &posterior::ParameterPrior::name);
  if (prior == priors.end() || !prior->normal) return nullptr;
  return {{"mean", prior->normal->mean}, {"sd", prior->normal->sd}};
}

Json parameters_of(const FrfAnswer& answer, const std::optional<sim::Parameters>& truth) {
  const frf::Fit& found = answer.found;
  const sim::ParameterTable& ranges = answer.density.ranges();
  const double mgh = mgh_of(answer.density);
  Json parameters = parameters_json(ranges, means(answer), mgh, truth);
  for (std::size_t p = 0; p < ranges.size(); ++p) {
    Json& json = parameters[p];
    add_found(json, found, p, ranges[p], mgh);
    json["range"] = {ranges[p].low, ranges[p].high};
    json["prior_sd"] = found.prior_stddev(static_cast<int>(p));
    json["contraction"] = found.contraction(static_cast<int>(p));
    if (answer.density.is_fixed(p)) json["fixed"] = true;
    if (Json prior = prior_json(answer.density, ranges[p].name); !prior.is_null()) json["prior"] = std::move(prior);
  }
  return parameters;
}

Warnings warnings_of(const FrfAnswer& answer) {
  return most_severe_first({answer.found.warnings(), body_warnings(body_of(answer.density))});
}

/// Returns the keys of one controller's answer.
Json answer_json(const FrfAnswer& answer, const std::optional<sim::Parameters>& truth) {
  const frf::Fit& found = answer.found;
  return {{"controller", answer.controller().name},
          {"parameters", parameters_of(answer, truth)},
          {"misfit",
           {{"chi_square", found.misfit().chi_square},
            {"degrees_of_freedom", found.misfit().degrees_of_freedom},
            {"p_value", number_or_null(found.misfit().p_value)},
            {"relative_error", found.left()}}},
          {"gain", quantity_json(found, found.gain())},
          {"error", quantity_json(found, found.error())},
          {"correlations", correlations_json(found, answer.density.ranges().size())},
          {"frf", table_json(answer)},
          {"diagnostics", diagnostics_json(found, answer.density.ranges())},
          {"trust", name(worst_trust(warnings_of(answer)))},
          {"warnings", warnings_json(warnings_of(answer))}};
}

Json compared_json(const FrfAnswer& answer) {
  return {{"controller", answer.controller().name},   {"log_predictive_density", answer.compared.log_density},
          {"difference", answer.compared.difference}, {"difference_standard_error", answer.compared.standard_error},
          {"weight", answer.compared.weight},         {"refitted_rows", answer.left_out.refitted},
          {"relative_error", answer.found.left()}};
}

void add(Json& json, const Json& others) {
  for (const auto& [key, value] : others.items()) json[key] = value;
}

std::string headline(const frf::Table& table) {
  return format("%s: %zu frequencies, %g to %g Hz", table.file.c_str(), table.rows.size(),
                table.rows.front().frequency_hz, table.rows.back().frequency_hz);
}

std::string misfit_text(const FrfAnswer& answer) {
  const frf::Table& table = answer.density.table();
  const frf::Misfit& misfit = answer.found.misfit();
  if (!table.has_confidence())
    return "  the table has no confidence intervals, so nothing says how well the fit agrees\n";
  return format("  by the table's %s chi-square is %.3g at %d degrees of freedom, posterior predictive p = %.2g\n",
                table.confidence.c_str(), misfit.chi_square, misfit.degrees_of_freedom, misfit.p_value);
}

std::string parameters_text(const FrfAnswer& answer, const std::optional<sim::Parameters>& truth) {
  const frf::Fit& found = answer.found;
  if (!found.explained())
    return "  decid shows no parameters, because no controller in the ranges has this response; the nearest ones "
           "have:\n";
  const sim::ParameterTable& ranges = answer.density.ranges();
  std::string text = table_heading(name_width(ranges), "estimate", truth.has_value(), " contraction");
  const sim::Parameters mean = means(answer);
  for (std::size_t p = 0; p < ranges.size(); ++p)
    text += parameter_line(
        found, p, ranges, mean[p], mgh_of(answer.density), truth,
        answer.density.is_fixed(p) ? "           -" : format(" %11.2f", found.contraction(static_cast<int>(p))));
  return text +
         "  contraction: fraction of the prior's variance that the table removes; at 0 the draws are the prior's\n";
}

std::string rows_text(const FrfAnswer& answer) {
  std::string text = format("  %8s %9s %9s %20s %9s %9s %20s %9s\n", "Hz", "gain", "model", "90% interval", "phase",
                            "model", "90% interval", "distance");
  const std::vector<Shown> rows = shown_rows(answer);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const frf::Predicted& predicted = answer.found.predicted()[i];
    const auto [low_deg, high_deg] = phase_interval(rows[i], predicted);
    text += format("  %8.4g %9.4g %9.4g %20s %9.1f %9.1f %20s %9.1f\n", rows[i].frequency_hz, rows[i].table.gain,
                   rows[i].model.gain, format("%.4g to %.4g", predicted.gain_low, predicted.gain_high).c_str(),
                   rows[i].table.phase_deg, rows[i].model.phase_deg, format("%.1f to %.1f", low_deg, high_deg).c_str(),
                   predicted.distance);
  }
  return text;
}

std::string answer_text(const FrfAnswer& answer, const std::optional<sim::Parameters>& truth, double seconds) {
  const frf::Fit& found = answer.found;
  std::string text = trust_text(warnings_of(answer), "table") + parameters_text(answer, truth);
  if (found.stddev(found.gain()) > 0.0)
    text += format("  scale of the table's gain %.3g +- %.2g (1 = correct)\n", found.mean(found.gain()),
                   found.stddev(found.gain()));
  if (found.stddev(found.error()) > 0.0)
    text += format("  errors%s %.2g +- %.1g%% of the response\n",
                   answer.density.table().has_confidence() ? " beyond the table's confidence intervals" : "",
                   100.0 * found.mean(found.error()), 100.0 * found.stddev(found.error()));
  text += rows_text(answer) + misfit_text(answer);
  text += format("  the mean response leaves %.1f%% (root mean square of the relative error)\n", 100.0 * found.left());
  text +=
      format("  calculation converged: %s (%d chains, %d draws, at least %.0f effective, R-hat at most %.3f; %.1f s)\n",
             found.agreed() ? "yes" : "no", found.chains(), found.draws(),
             *std::ranges::min_element(found.effective_draws()), *std::ranges::max_element(found.rhat()), seconds);
  return text + warnings_text(warnings_of(answer));
}

std::string comparison_text(const std::vector<FrfAnswer>& answers) {
  std::string text = format("  %-10s %24s %26s %8s %16s\n", "controller", "log predictive density", "difference",
                            "weight", "relative error");
  for (const FrfAnswer& answer : answers) {
    const posterior::ComparedModel& compared = answer.compared;
    text += format("  %-10s %24.1f %26s %8.2f %15.1f%%\n", answer.controller().name.c_str(), compared.log_density,
                   difference_text(compared.difference, compared.standard_error).c_str(), compared.weight,
                   100.0 * answer.found.left());
  }
  return text + "  log predictive density: sum over the rows of log p(row | all other rows), nats\n";
}

}  // namespace

Json frf_fit_object(const FrfReport& report) {
  const FrfAnswer& first = report.answers.front();
  const sim::Protocol& protocol = first.density.model().protocol();
  const frf::Table& table = first.density.table();
  Json json{{"options", report.options},
            {"body", body_json(protocol.experiment.body, report.body_assumed)},
            {"file", table.file},
            {"protocol", protocol.name},
            {"confidence", table.has_confidence() ? Json(table.confidence) : Json(nullptr)},
            {"fit", {{"answer", "posterior"}, {"seconds", report.seconds}}}};
  add(json, answer_json(first, report.truth));
  if (report.answers.size() > 1) {
    Json& list = json["controllers"] = Json::array();
    for (const FrfAnswer& answer : report.answers) {
      Json& each = list.emplace_back(compared_json(answer));
      if (&answer != &first) add(each, answer_json(answer, {}));
    }
  }
  return json;
}

std::string frf_fit_text(const FrfReport& report) {
  const FrfAnswer& first = report.answers.front();
  const bool several = report.answers.size() > 1;
  std::string text = headline(first.density.table()) + "\n";
  if (several) text += comparison_text(report.answers);
  for (const FrfAnswer& answer : report.answers) {
    if (several) text += "\n" + answer.controller().name + ", " + answer.controller().description + "\n";
    text += answer_text(answer, report.truth, report.seconds);
  }
  return text + body_text(body_of(first.density), report.body_assumed);
}

void write_frf_draws(const std::filesystem::path& path, const FrfReport& report) {
  const frf::Fit& found = report.answers.front().found;
  const std::size_t parameters = report.answers.front().density.ranges().size();
  const auto draws = static_cast<std::size_t>(found.draws());
  std::vector<double> matrix, chain;
  for (std::size_t draw = 0; draw < draws; ++draw) {
    for (std::size_t p = 0; p < parameters; ++p) matrix.push_back(found.draws_for(static_cast<int>(p))[draw]);
    const int number = static_cast<int>(draw) / found.draws_per_chain();
    chain.push_back(number);
  }
  const std::vector<dataset::NamedArray> arrays{{"parameters", {draws, parameters}, matrix},
                                                {"gain", {draws}, found.draws_for(found.gain())},
                                                {"error", {draws}, found.draws_for(found.error())},
                                                {"chain", {draws}, chain}};
  dataset::write_arrays(path, arrays);
}

namespace {

Json answer_json(const LogRatioAnswer& answer, const std::optional<sim::Parameters>& truth) {
  const sim::ParameterTable& ranges = answer.density.ranges();
  Json parameters = parameters_json(ranges, answer.found.state.parameters, mgh_of(answer.density), truth);
  for (std::size_t p = 0; p < ranges.size(); ++p) {
    parameters[p]["range"] = {ranges[p].low, ranges[p].high};
    parameters[p]["at_end"] = static_cast<bool>(answer.found.at_end[p]);
    if (answer.density.is_fixed(p)) parameters[p]["fixed"] = true;
  }
  return {{"controller", answer.density.model().protocol().experiment.body_model->name},
          {"parameters", std::move(parameters)},
          {"passing_gain", answer.found.passing_gain},
          {"misfit", {{"log_ratio", answer.found.misfit}, {"relative_error", answer.found.left}}},
          {"frf", rows_json(shown_rows(answer.density.table(), answer.found.responses),
                            {"frequency_hz", "gain", "phase_deg", "model_gain", "model_phase_deg"})},
          {"diagnostics", {{"agreeing_starts", answer.found.agreeing}}},
          {"trust", name(worst_trust(answer.found.warnings))},
          {"warnings", warnings_json(answer.found.warnings)}};
}

std::string answer_text(const LogRatioAnswer& answer, const std::optional<sim::Parameters>& truth) {
  const sim::ParameterTable& ranges = answer.density.ranges();
  const int width = name_width(ranges);
  std::string text = format("  %-*s %10s %-10s %14s%s  %s\n", width, "", "estimate", "unit", "or",
                            truth ? "       true" : "", "model's limits");
  for (std::size_t p = 0; p < ranges.size(); ++p) {
    const double value = answer.found.state.parameters[p];
    text += format("  %-*s %10.5g %-10s %14s", width, shown_name(ranges[p]).c_str(), value,
                   ranges[p].shown_unit().c_str(), in_other_unit(ranges[p], value, mgh_of(answer.density)).c_str());
    if (truth) text += format(" %10.5g", (*truth)[p]);
    text += format("  %g to %g%s\n", ranges[p].low, ranges[p].high,
                   answer.density.is_fixed(p) ? ", fixed"
                   : answer.found.at_end[p]   ? ", at its end"
                                              : "");
  }
  text += format("  the dead band passes %.2f; the response determines only this combination of Nv and theta\n",
                 answer.found.passing_gain);
  text += format("  %8s %9s %9s %9s %9s\n", "Hz", "gain", "model", "phase", "model");
  for (const Shown& row : shown_rows(answer.density.table(), answer.found.responses))
    text += format("  %8.4g %9.4g %9.4g %9.1f %9.1f\n", row.frequency_hz, row.table.gain, row.model.gain,
                   row.table.phase_deg, row.model.phase_deg);
  text += format("  the fit leaves %.1f%% (root mean square of the relative error); %d starts agree\n",
                 100.0 * answer.found.left, answer.found.agreeing);
  return text + warnings_text(answer.found.warnings);
}

}  // namespace

Json log_ratio_object(const LogRatioReport& report) {
  const LogRatioAnswer& first = report.answers.front();
  const sim::Protocol& protocol = first.density.model().protocol();
  Json json{{"options", report.options},
            {"body", body_json(protocol.experiment.body, report.body_assumed)},
            {"file", first.density.table().file},
            {"protocol", protocol.name},
            {"fit", {{"answer", "log-ratio"}, {"seconds", report.seconds}}},
            {"warnings", warnings_json(body_warnings(protocol.experiment.body))}};
  add(json, answer_json(first, report.truth));
  if (report.answers.size() > 1) {
    Json& list = json["controllers"] = Json::array();
    for (const LogRatioAnswer& answer : report.answers) list.push_back(answer_json(answer, {}));
  }
  return json;
}

std::string log_ratio_text(const LogRatioReport& report) {
  const LogRatioAnswer& first = report.answers.front();
  std::string text = headline(first.density.table()) + "; least squares of the log ratio\n";
  for (const LogRatioAnswer& answer : report.answers) {
    const sim::BodyModel& controller = *answer.density.model().protocol().experiment.body_model;
    if (report.answers.size() > 1) text += "\n" + controller.name + ", " + controller.description + "\n";
    text += answer_text(answer, report.truth);
  }
  for (const Warning& warning : body_warnings(body_of(first.density))) text += warning_line(warning);
  return text + body_text(body_of(first.density), report.body_assumed);
}

}  // namespace decid::tools
