// Identifications as JSON and text: see results.hpp.
#include "tools/decid/results.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "tools/report/frf.hpp"

namespace decid::tools {
namespace {

using Json = nlohmann::ordered_json;

Json number_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

}  // namespace

Json recording_json(const Identification& id) {
  if (id.error) return {{"file", id.file}, {"error", id.error->what()}};
  Json parameters = Json::array();
  for (std::size_t p = 0; p < sim::parameter_count; ++p) {
    const sim::ParameterInfo& info = sim::parameter_info[p];
    Json parameter{{"name", info.name}, {"value", number_or_null(id.parameters[p])}, {"unit", info.unit}};
    parameter["normalized"] = info.per_mgh ? number_or_null(id.parameters[p] / id.protocol.body.mgh()) : Json(nullptr);
    if (id.truth) parameter["true"] = (*id.truth)[p];
    parameters.push_back(std::move(parameter));
  }
  Json recording{{"file", id.file},
                 {"parameters", std::move(parameters)},
                 {"fit",
                  {{"rms_residual_deg", number_or_null(id.rms_residual_deg)},
                   {"variance_accounted_for", number_or_null(id.variance_accounted_for)}}},
                 {"peak_to_peak_deg", id.peak_to_peak_deg},
                 {"following", number_or_null(id.following)},
                 {"unfamiliarity", number_or_null(id.unfamiliarity)}};
  if (id.tilt) {
    recording["tilt"] = {{"column", id.tilt_column},
                         {"delay_s", id.tilt->delay_s},
                         {"correlation", id.tilt->correlation},
                         {"gain", id.tilt->gain}};
  }
  recording["frf"] = id.frf ? frf_to_json(*id.frf) : Json(nullptr);
  recording["warnings"] = id.warnings;
  return recording;
}

std::string recordings_json(const std::string& model, const Json& recordings) {
  // A file name need not be UTF-8; what is not is replaced, not thrown at the user.
  return Json{{"model", model}, {"recordings", recordings}}.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string identifications_json(const std::string& model, const std::vector<Identification>& all) {
  Json recordings = Json::array();
  for (const Identification& id : all) recordings.push_back(recording_json(id));
  return recordings_json(model, recordings);
}

std::string headline(const Identification& id) {
  std::string text =
      format("%s (%s): peak to peak %.3f degrees", id.file.c_str(), id.column.c_str(), id.peak_to_peak_deg);
  if (std::isfinite(id.rms_residual_deg))
    text += format(", rms residual %.3f degrees, variance accounted for %.1f%%", id.rms_residual_deg,
                   100 * id.variance_accounted_for);
  if (std::isfinite(id.following)) text += format(", follows the tilt %.2f", id.following);
  if (id.tilt) {
    text += format("\n  the protocol starts %.3f s after the recording by its tilt %s (correlation %.3f, gain %.3f)",
                   id.tilt->delay_s, id.tilt_column.c_str(), id.tilt->correlation, id.tilt->gain);
  }
  return text + "\n";
}

std::string identifications_text(const std::vector<Identification>& all) {
  std::string text;
  for (const Identification& id : all) {
    if (id.error) {
      text += id.file + ": not identified\n";
      continue;
    }
    text += headline(id);
    text += format("  %-8s %12s %-10s %10s%s  %s\n", "", "identified", "unit", "/ (m g h)",
                   id.truth ? "         true" : "", "range");
    for (std::size_t p = 0; p < sim::parameter_count; ++p) {
      const sim::ParameterInfo& info = sim::parameter_info[p];
      text += format("  %-8s %12.5g %-10s ", info.name, id.parameters[p], info.shown_unit());
      text += info.per_mgh ? format("%10.4f", id.parameters[p] / id.protocol.body.mgh()) : std::string(10, ' ');
      if (id.truth) text += format(" %12.5g", (*id.truth)[p]);
      text += format("  %g to %g\n", info.low, info.high);
    }
    for (const std::string& warning : id.warnings) text += "  warning: " + warning + "\n";
  }
  return text;
}

}  // namespace decid::tools
