// Identifications as JSON and text: see results.hpp.
#include "tools/decid/results/results.hpp"

#include <cmath>
#include <optional>

#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "sim/segments.hpp"
#include "tools/decid/results/posterior_results.hpp"
#include "tools/report/frf.hpp"
#include "tools/report/parameters_json.hpp"
#include "tools/report/recording_json.hpp"

namespace decid::tools {
namespace {

std::string point_table(const Identification& id, const sim::Protocol& protocol) {
  const sim::ParameterTable table = protocol.ranges();
  std::string text = format("  %-8s %10s %12s %-10s%s  %s\n", "", "/ (m g h)", "identified", "unit",
                            id.truth ? "         true" : "", "range");
  for (std::size_t p = 0; p < table.size(); ++p) {
    const sim::ParameterInfo& info = table[p];
    text += format("  %-8s ", info.name.c_str()) +
            over_mgh(info, id.estimate.parameters[p], protocol.experiment.body.mgh());
    text += format(" %12.5g %-10s", id.estimate.parameters[p], info.shown_unit().c_str());
    if (id.truth) text += format(" %12.5g", (*id.truth)[p]);
    text += format("  %g to %g\n", info.low, info.high);
  }
  return text;
}

std::string distribution_table(const Identification& id, const sim::Protocol& protocol) {
  const sim::ParameterTable table = protocol.ranges();
  std::string text = table_heading("identified", "90 % interval", id.truth.has_value());
  for (std::size_t p = 0; p < table.size(); ++p)
    text += parameter_line(*id.estimate.distribution, p, table[p], id.estimate.parameters[p],
                           protocol.experiment.body.mgh(), id.truth);
  return text;
}

void add_distribution(Json& recording, const ParameterDistribution& found, const sim::Protocol& protocol) {
  const sim::ParameterTable table = protocol.ranges();
  for (std::size_t p = 0; p < table.size(); ++p)
    add_found(recording["parameters"][p], found, p, table[p], protocol.experiment.body.mgh());
  recording["correlations"] = correlations_json(found, table.size());
}

}  // namespace

Json recording_json(const Identification& id, const sim::Protocol& protocol) {
  if (id.error) return {{"file", id.file}, {"error", id.error->what()}};
  const Explanation& explanation = id.explanation;
  const std::optional<recording::TiltMatch>& tilt = id.estimate.trial.tilt;
  Json recording{{"file", id.file},
                 {"parameters", parameters_json(protocol.parameters(), id.estimate.parameters,
                                                protocol.experiment.body.mgh(), id.truth)},
                 {"fit",
                  {{"rms_residual_deg", number_or_null(explanation.rms_residual_deg)},
                   {"variance_accounted_for", number_or_null(explanation.variance_accounted_for)}}},
                 {"peak_to_peak_deg", id.peak_to_peak_deg()},
                 {"following", number_or_null(explanation.following)},
                 {"unfamiliarity", number_or_null(explanation.unfamiliarity)}};
  const sim::ParameterTable ranges = protocol.ranges();
  for (std::size_t p = 0; p < ranges.size(); ++p) recording["parameters"][p]["range"] = {ranges[p].low, ranges[p].high};
  if (tilt) {
    recording["tilt"] = {{"column", id.tilt_column},
                         {"delay_s", tilt->delay_s},
                         {"correlation", tilt->correlation},
                         {"gain", tilt->gain}};
  }
  recording["frf"] = explanation.frf ? frf_to_json(*explanation.frf) : Json(nullptr);
  recording["trust"] = name(id.trust());
  recording["warnings"] = warnings_json(id.warnings());
  if (id.estimate.distribution) add_distribution(recording, *id.estimate.distribution, protocol);
  return recording;
}

namespace {

/// Returns the weight and height of a person with this body, or nothing if no person has it.
std::optional<sim::Subject> person_of(const sim::Body& body) {
  try {
    return sim::subject_of(body);
  } catch (const Error&) {
    return {};
  }
}

}  // namespace

Json body_json(const sim::Body& body, bool assumed) {
  Json json{{"mass_kg", body.mass_kg},
            {"com_height_m", body.com_height_m},
            {"inertia_kgm2", body.inertia_kgm2},
            {"assumed", assumed}};
  if (const std::optional<sim::Subject> person = person_of(body))
    json["person"] = Json{{"mass_kg", person->mass_kg}, {"height_m", person->height_m}};
  return json;
}

std::string recordings_json(const MadeWith& with, const Identifications& all, const Json& recordings,
                            const Json& groups) {
  Json json{{"decid", version},
            {"model", with.model},
            {"model_sha256", with.weights_sha256},
            {"options", with.options},
            {"protocol", parse_json(sim::to_json(all.protocol), "protocol")},
            {"body", body_json(all.protocol.experiment.body, all.body_assumed)},
            {"other_answer", other_answer_json(with.other_answer)},
            {"recordings", recordings}};
  if (!groups.is_null()) json.update(groups);
  // A file name need not be UTF-8; other bytes are replaced.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string body_text(const Identifications& all) {
  return body_text(all.protocol.experiment.body, all.body_assumed);
}

namespace {

std::string person_text(const sim::Body& body) {
  const std::optional<sim::Subject> person = person_of(body);
  return person ? format("; a person of %.1f kg and %.2f m", person->mass_kg, person->height_m) : "";
}

}  // namespace

std::string body_text(const sim::Body& body, bool assumed) {
  const std::string text = format("Body: %.1f kg above the ankles, centre of mass at %.3f m, m g h %.0f N m/rad",
                                  body.mass_kg, body.com_height_m, body.mgh()) +
                           person_text(body);
  if (!assumed) return text + ".\n";
  return text +
         ". It is assumed: stiffness and damping of another body of that height are these over its m g h "
         "(--mass, --height).\n";
}

Json identifications_list(const Identifications& all) {
  Json recordings = Json::array();
  for (const Identification& id : all.recordings) recordings.push_back(recording_json(id, all.protocol));
  return recordings;
}

std::string trust_text(const Warnings& warnings) {
  const Trust trust = trust_of(warnings);
  if (trust == Trust::usable) return "  usable: no check found anything odd\n";
  return (trust == Trust::caution ? "  with caution: " : "  NOT USABLE: ") + gravest(warnings)->text + "\n";
}

std::string warnings_text(const Warnings& warnings) {
  std::string text;
  for (auto w = warnings.begin(); w != warnings.end(); ++w)
    if (w->severity == Severity::info)
      text += "  note: " + w->text + "\n";
    else if (w != gravest(warnings))
      text += "  warning: " + w->text + "\n";
  return text;
}

std::string headline(const Identification& id) {
  return format("%s (%s)\n", id.file.c_str(), id.column.c_str()) + trust_text(id.warnings());
}

std::string sway_text(const Identification& id) {
  std::string text = format("  sway: peak to peak %.3f degrees", id.peak_to_peak_deg());
  if (std::isfinite(id.explanation.rms_residual_deg))
    text += format(", rms residual %.3f degrees, variance accounted for %.1f%%", id.explanation.rms_residual_deg,
                   100 * id.explanation.variance_accounted_for);
  if (std::isfinite(id.explanation.following)) text += format(", follows the tilt %.2f", id.explanation.following);
  if (id.estimate.trial.tilt) {
    text += format("\n  the protocol starts %.3f s after the recording by its tilt %s (correlation %.3f, gain %.3f)",
                   std::round(1e3 * id.estimate.trial.tilt->delay_s) / 1e3 + 0.0,  // no -0.000
                   id.tilt_column.c_str(), id.estimate.trial.tilt->correlation, id.estimate.trial.tilt->gain);
  }
  return text + "\n";
}

std::string identification_text(const Identification& id, const sim::Protocol& protocol) {
  if (id.error) return id.file + ": not identified\n";
  return headline(id) + (id.estimate.distribution ? distribution_table(id, protocol) : point_table(id, protocol)) +
         sway_text(id) + warnings_text(id.warnings());
}

std::string identifications_text(const Identifications& all) {
  std::string text;
  for (const Identification& id : all.recordings) text += identification_text(id, all.protocol);
  return text + body_text(all);
}

}  // namespace decid::tools
