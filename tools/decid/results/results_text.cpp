// Reports as text: see results.hpp.
#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "sim/segments.hpp"
#include "tools/decid/results/group_results.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/json/posterior_results.hpp"

namespace decid::tools {
namespace {

using posterior::Density;

std::string point_table(const RecordingResult& id, const Report& report) {
  const sim::ParameterTable table = report.ranges_for(id);
  const int width = name_width(table);
  std::string text = format("  %-*s %10s %-10s %14s%s  %s\n", width, "", "estimate", "unit", "or",
                            id.truth ? "       true" : "", "model's limits");
  for (std::size_t p = 0; p < table.size(); ++p) {
    const sim::ParameterInfo& info = table[p];
    const double value = id.estimate.parameters[p];
    text += format("  %-*s %10.5g %-10s %14s", width, shown_name(info).c_str(), value, info.shown_unit().c_str(),
                   in_other_unit(info, value, report.protocol_for(id).experiment.body.mgh()).c_str());
    if (id.truth) text += format(" %10.5g", (*id.truth)[p]);
    text += format("  %g to %g\n", info.low, info.high);
  }
  return text;
}

template <class Found>
std::string distribution_table(const RecordingResult& id, const Report& report, const Found& found) {
  const sim::ParameterTable table = report.ranges_for(id);
  const bool from_network = id.fit && id.fit->answer == FitFigures::Answer::network;
  std::string text = table_heading(name_width(table), from_network ? "network" : "estimate", id.truth.has_value());
  for (std::size_t p = 0; p < table.size(); ++p)
    text += parameter_line(found, p, table, id.estimate.parameters[p], report.protocol_for(id).experiment.body.mgh(),
                           id.truth);
  return text;
}

std::string parameters_text(const RecordingResult& id, const Report& report) {
  if (id.estimate.distribution) return distribution_table(id, report, *id.estimate.distribution);
  if (id.fit) return distribution_table(id, report, id.fit->posterior);
  return point_table(id, report);
}

/// Returns the p-values in one line.
std::string check_text(const PredictiveCheck& check) {
  if (check.figures.empty()) return {};
  const auto text_of = [](const CheckedFigure& figure) { return format("%s %.2g", figure.name.c_str(), figure.p); };
  return "  predictive check, p: " + joined(check.figures, ", ", text_of) + "\n";
}

/// Returns the table of the fitted controllers, the one that answers first.
std::string controllers_text(const FitFigures& fitted, const std::string& own) {
  if (!fitted.compared) return {};
  std::string text = format("  %-10s %24s %26s %8s\n", "controller", "log predictive density", "difference", "weight");
  const auto line = [&](const std::string& name, const posterior::ComparedModel& compared, bool comparable) {
    text += format("  %-10s %24.1f %26s %8.2f%s\n", name.c_str(), compared.log_density,
                   difference_text(compared.difference, compared.standard_error).c_str(), compared.weight,
                   comparable ? "" : "  not comparable");
  };
  line(own, *fitted.compared, fitted.comparable);
  for (const ControllerFit& other : fitted.others) line(other.controller, other.compared, other.comparable);
  return text;
}

/// Returns the line of an inferred start; empty if it was known.
std::string start_text(double mean_s, double sd_s) {
  if (!(sd_s > 0.0)) return {};
  return format("  the recording starts %.2g s %s the protocol (sd %.2g s)\n", std::abs(mean_s),
                mean_s < 0.0 ? "before" : "after", sd_s);
}

/// Returns the lines of a fit below its parameters.
std::string fit_text(const FitFigures& fitted) {
  const posterior::Posterior& found = fitted.posterior;
  std::string text;
  const auto line = [&](const char* what, int quantity, const char* unit) {
    if (found.stddev(quantity) > 0.0)
      text += format("  %s %.3g +- %.2g%s\n", what, found.mean(quantity), found.stddev(quantity), unit);
  };
  line("measurement noise", Density::sensor_noise, " degrees");
  text += format("  slow noise %.3g degrees, correlation time %.2g s\n", found.mean(Density::slow_noise),
                 found.mean(Density::slow_memory));
  text += start_text(found.mean(Density::start), found.stddev(Density::start));
  line("scale of the sway sensor", Density::gain, " (1 = correct)");
  if (fitted.joint) {
    text +=
        "  fitted together with " + counted(static_cast<long long>(fitted.joint->files.size()) - 1, "other recording");
    for (const std::string& name : fitted.joint->freed) text += ", " + name + " with those of the same condition";
    text += "\n";
  }
  const auto worst = std::ranges::max_element(found.rhat());
  const auto fewest = std::ranges::min_element(found.effective_draws());
  text += format(
      "  calculation converged: %s (%d chains, %d draws, at least %.0f effective, R-hat at most %.3f, %s; "
      "%.1f s)\n",
      found.agreed() ? "yes" : "no", found.chains(), found.draws(), *fewest, *worst,
      counted(found.divergences(), "divergence").c_str(), fitted.seconds);
  return text + check_text(fitted.check);
}

/// Returns the fraction of the variance that the estimate explains, for people.
std::string explained_text(double part) {
  return part > 0.0 ? format("%.1f%%", 100.0 * part) : "none";
}

std::string sway_text(const RecordingResult& id) {
  std::string text = format("  sway: peak to peak %.3f degrees", id.peak_to_peak_deg());
  if (std::isfinite(id.explanation.rms_residual_deg))
    text += format("; explained without noise: %s, residual %.3f degrees rms",
                   explained_text(id.explanation.variance_accounted_for).c_str(), id.explanation.rms_residual_deg);
  if (std::isfinite(id.explanation.response_ratio))
    text += format("; stimulus response ratio %.2f", id.explanation.response_ratio);
  if (id.trial.tilt) {
    const double gain = id.trial.tilt->gain;
    text += format("\n  platform movement found at %.3f s (column %s, correlation %.3f, %s)",
                   std::round(1e3 * id.trial.tilt->delay_s) / 1e3 + 0.0,  // no -0.000
                   id.tilt_column.c_str(), id.trial.tilt->correlation,
                   std::isnan(gain) ? "size unknown (no unit)" : format("gain %.3f", gain).c_str());
  }
  return text + "\n";
}

/// Returns the person's line of a study: ", sub-01, ses-2, patients, eyes closed".
std::string who_text(const SheetEntry& entry) {
  std::string text;
  for (const std::string* part : {&entry.participant, &entry.session, &entry.group, &entry.condition})
    if (!part->empty()) text += ", " + *part;
  return text;
}

std::string recording_text(const RecordingResult& id, const Report& report) {
  const std::string who = who_text(id.entry);
  if (id.error) return id.file + who + ": not analysed\n";
  return format("%s (%s)%s\n", id.file.c_str(), id.column.c_str(), who.c_str()) + trust_text(id.warnings) +
         parameters_text(id, report) +
         (id.fit ? controllers_text(*id.fit, report.protocol_for(id).experiment.body_model->name) + fit_text(*id.fit)
                 : "") +
         sway_text(id) +
         (report.sheet ? "  " + body_text(report.protocol_for(id).experiment.body, report.setting_of(id).body_assumed,
                                          "give the person's weight and height in the sheet")
                       : "") +
         warnings_text(id.warnings);
}

std::string participant_text(const sim::Body& body) {
  const std::optional<sim::Participant> participant = find_participant(body);
  return participant ? format("a person of %.1f kg and %.2f m, ", participant->mass_kg, participant->height_m) : "";
}

}  // namespace

std::string body_text(const sim::Body& body, bool assumed, const std::string& remedy) {
  std::string text = std::string(assumed ? "Body (assumed): " : "Body: ") + participant_text(body) +
                     format("%.1f kg above the ankles, centre of mass at %.3f m, m g h %s N m/rad.\n", body.mass_kg,
                            body.com_height_m, sim::mgh_text(body.mgh()).c_str());
  if (assumed) return text + "Values in N m/rad and N m s/rad are not this person's: " + remedy + ".\n";
  return text;
}

std::string trust_text(const Warnings& warnings, const std::string& what) {
  const Trust trust = worst_trust(warnings);
  return "  " + std::string(name(trust)) + ": " +
         (trust == Trust::usable ? what + " passed all checks" : most_severe(warnings)->text) + "\n";
}

std::string warning_line(const Warning& warning) {
  return "  " + std::string(name(warning.severity)) + ": " + warning.text + "\n";
}

std::string warnings_text(const Warnings& warnings) {
  std::string text;
  for (auto w = warnings.begin(); w != warnings.end(); ++w)
    if (w->severity == Severity::info || w != most_severe(warnings)) text += warning_line(*w);
  return text;
}

std::string name_and_unit(const sim::ParameterInfo& info, const std::string& per) {
  const std::string unit = info.shown_unit() + per;
  return info.name + (unit.empty() ? "" : "," + std::string(unit.starts_with(' ') ? "" : " ") + unit);
}

std::string difference_text(double difference, double standard_error) {
  return difference < 0.0 ? format("%.1f +- %.1f", difference, standard_error) : std::string("best");
}

std::string controller_sums_text(const ControllerSums& sums) {
  std::string text = format("Controllers over %zu recordings, not people\n", sums.recordings) +
                     format("  %-10s %24s %26s %8s\n", "controller", "log predictive density", "difference", "best in");
  for (const SummedController& one : sums.controllers)
    text += format("  %-10s %24.1f %26s %8zu\n", one.name.c_str(), one.log_density,
                   difference_text(one.difference, one.standard_error).c_str(), one.best_in);
  if (sums.not_usable > 0)
    text += "  with " + counted(static_cast<long long>(sums.not_usable), "recording") + " not usable\n";
  if (sums.not_comparable > 0)
    text += "  with " + counted(static_cast<long long>(sums.not_comparable), "recording") +
            " of which a fit is not comparable\n";
  return text;
}

std::string report_text(const Report& report) {
  std::string text = summary_text(report);
  for (const RecordingResult& id : report.recordings) text += recording_text(id, report);
  const std::string body =
      report.sheet ? std::string() : body_text(report.protocol.experiment.body, report.body_assumed);
  if (!report.fit) return text + body + groups_text(report);
  const std::optional<ControllerSums> sums = sum_controllers(report);
  return valid_utf8(text) + groups_text(report) + body + (sums ? controller_sums_text(*sums) : "");
}

Call record_call(const Command& command, const std::vector<std::string>& inputs,
                 const std::vector<std::string>& named) {
  Call call{command.name(), command.arguments(), hash_inputs(inputs), {}};
  const auto may_be_option = [](const std::string& file) { return file.starts_with('-') && file.size() > 1; };
  if (std::ranges::any_of(named, may_be_option)) call.arguments.emplace_back("--");
  std::ranges::copy_if(named, std::back_inserter(call.arguments),
                       [](const std::string& file) { return !file.empty(); });
  return call;
}

}  // namespace decid::tools
