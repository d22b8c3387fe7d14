// Groups compared as text: see group_results.hpp.
#include "tools/decid/results/group_results.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "sim/segments.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/json/group_verdicts.hpp"

namespace decid::tools {
namespace {

std::string number_text(double value, const char* pattern) {
  if (!std::isfinite(value)) return "-";
  char text[64];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

std::string interval_text(const std::array<double, 2>& interval) {
  if (std::isnan(interval[0]) && std::isnan(interval[1])) return "-";
  return number_text(interval[0], "%.4g") + " to " + number_text(interval[1], "%.4g");
}

std::string people_text(std::size_t count) {
  return count == 1 ? "1 person" : format("%zu people", count);
}

std::string group_text(const Group& group, const sim::ParameterTable& table) {
  std::string text = "  " + one_line(group.name) + ": " + people_text(group.participants) + ", " +
                     counted(static_cast<long long>(group.recordings), "recording") + "\n";
  if (group.participants == 0) return text + "    no usable recording\n";
  for (std::size_t p = 0; p < table.size(); ++p) {
    const std::string unit = table[p].shown_unit();
    const double sd = group.parameters[p].sd;
    text += format("    %-8s %12.5g%s%s\n", table[p].name.c_str(), group.parameters[p].mean,
                   std::isfinite(sd) ? format(" +- %.3g", sd).c_str() : "", unit.empty() ? "" : (" " + unit).c_str());
  }
  return group.participants == 1 ? text + "    one person: no standard deviation; record more people\n" : text;
}

/// Returns name_and_unit() of a table's rows, all of one width.
std::vector<std::string> row_labels(const sim::ParameterTable& table, const std::string& per = {}) {
  std::vector<std::string> labels;
  std::size_t width = 0;
  for (const sim::ParameterInfo& info : table) {
    labels.push_back(name_and_unit(info, per));
    width = std::max(width, labels.back().size());
  }
  for (std::string& label : labels) label.resize(width, ' ');
  return labels;
}

/// Returns a line of headings above row_labels().
std::string headings(const std::vector<std::string>& labels, const std::string& columns) {
  return "    " + std::string(labels.empty() ? 0 : labels.front().size(), ' ') + columns + "\n";
}

/// Returns why intervals are missing; empty if none is.
std::string missing_intervals_text(const GroupPair& pair, const sim::ParameterTable& table) {
  std::string without;
  for (std::size_t p = 0; p < table.size(); ++p)
    if (!std::isfinite(pair.parameters[p].interval95[0])) without += (without.empty() ? "" : ", ") + table[p].name;
  if (without.empty()) return {};
  if (std::ranges::min(pair.participants) < 2)
    return pair.paired ? "    one person in both groups: no interval of the mean; record more people\n"
                       : "    a group of one person: no interval; record more people\n";
  return std::string("    ") + missing_interval_reason(pair) + ": no interval of " + without + "\n";
}

std::string pair_text(const GroupPair& pair, const std::vector<Group>& groups, const sim::ParameterTable& table) {
  std::string text = "  " + one_line(groups[pair.first].name) + " minus " + one_line(groups[pair.second].name);
  text += pair.paired ? ", paired: " + people_text(pair.participants[0]) + " in both groups\n"
                      : ": " + people_text(pair.participants[0]) + " and " + people_text(pair.participants[1]) + "\n";
  if (pair.unpaired_participants != 0)
    text += "    without " + people_text(pair.unpaired_participants) + " in only one of the two groups\n";
  const std::vector<std::string> labels = row_labels(table);
  text +=
      headings(labels, format(" %12s %24s %24s %10s", "difference", "95% interval", "adjusted interval", "Hedges' g"));
  for (std::size_t p = 0; p < table.size(); ++p) {
    const GroupEffect& effect = pair.parameters[p];
    text += format("    %s %12s %24s %24s %10s\n", labels[p].c_str(), number_text(effect.difference, "%.4g").c_str(),
                   interval_text(effect.interval95).c_str(), interval_text(effect.adjusted_interval95).c_str(),
                   number_text(effect.hedges_g, "%.2f").c_str());
  }
  return text + missing_intervals_text(pair, table);
}

std::string left_out_text(const Report& report) {
  std::string text;
  long long count = 0;
  for (std::size_t i = 0; i < report.recordings.size(); ++i) {
    const std::string& reason = report.groups->left_out[i];
    if (reason.empty()) continue;
    ++count;
    const std::string cell = report.groups->table.members[i].cell();
    text += "    " + one_line(report.recordings[i].file) + (cell.empty() ? "" : " (" + one_line(cell) + ")") + ": " +
            reason + "\n";
  }
  return count == 0 ? text : "  Left out: " + counted(count, "recording") + "\n" + text;
}

/// Returns a reason of cohort::WithoutEvidence for people.
std::string reason_text(const std::string& reason) {
  if (reason == "no_distribution") return "has no distribution of these parameters";
  if (reason == "few_draws") return "has fewer than 16 draws";
  if (reason == "other_ranges")
    return "its ranges relative to m g h differ from the first recording's: the same range in N m/rad is another one "
           "for each body; give the range over m g h: --range Kp/mgh=LOW,HIGH";
  if (reason == "narrow_prior") return "its normal prior is narrower than the information of the recording";
  return "its draws do not vary in every parameter";
}

std::string without_distribution_text(const Report& report) {
  const std::vector<cohort::WithoutEvidence>& without = report.groups->without_distribution;
  if (without.empty()) return {};
  std::string text =
      "  Not in the hierarchical model: " + counted(static_cast<long long>(without.size()), "recording") + "\n";
  for (const cohort::WithoutEvidence& one : without)
    text += "    " + one_line(report.recordings[one.recording].file) + ": " + reason_text(one.reason) + "\n";
  return text;
}

std::string fixed_text(const Report& report) {
  const std::string text = joined(report.fixed_parameters(), ", ");
  return text.empty() ? text : "  Fixed, and so not compared: " + text + "\n";
}

std::string bodies_text(const GroupReport& groups) {
  std::string text;
  if (groups.bodies_differ)
    text +=
        format("  The people's bodies differ: stiffness and damping are scaled by m g h to one body, of %s N m/rad.\n",
               sim::mgh_text(groups.mgh_nm_rad).c_str());
  if (groups.assumed_bodies > 0)
    text += "  " + counted(static_cast<long long>(groups.assumed_bodies), "recording") +
            " with an assumed body: differences in stiffness and damping contain body size; give mass and height.\n";
  return text;
}

std::string difference_name(const cohort::Result& found, const cohort::Comparison& comparison) {
  return one_line(found.cells[comparison.first].name()) + " minus " + one_line(found.cells[comparison.second].name());
}

std::string effects_text(const std::vector<cohort::Effect>& effects, const sim::ParameterTable& table) {
  const std::vector<std::string> labels = row_labels(table);
  std::string text = headings(labels, format(" %12s %24s %24s %24s %9s", "difference", "95% interval",
                                             "simultaneous interval", "over participant sd", "direction"));
  for (std::size_t p = 0; p < table.size(); ++p) {
    const cohort::Effect& effect = effects[p];
    text += format("    %s %12.4g %24s %24s %24s %8.1f%%\n", labels[p].c_str(), effect.difference.mean,
                   interval_text(effect.difference.interval95).c_str(), interval_text(effect.simultaneous95).c_str(),
                   interval_text(effect.standardised.interval95).c_str(), 100.0 * effect.direction);
  }
  return text;
}

/// Returns the unit of a sheet's column of numbers; empty if it has none that decid knows.
std::string covariate_unit(const std::string& column) {
  if (names_weights(column)) return "kg";
  return names_heights(column) ? "m" : "";
}

std::string covariate_text(const cohort::Covariate& covariate, const sim::ParameterTable& table) {
  const std::string unit = covariate_unit(covariate.name);
  std::string text =
      "  Change per " + (unit.empty() ? "unit" : unit) + " of " + one_line(covariate.name) +
      format("; means are at %.4g%s", covariate.mean, unit.empty() ? "" : (" " + unit).c_str()) +
      (covariate.unknown == 0 ? ""
                              : "; " + counted(static_cast<long long>(covariate.unknown), "recording") +
                                    " without a value: the person's in another one, else the group's mean") +
      "\n";
  const std::vector<std::string> labels = row_labels(table, unit.empty() ? "" : " per " + unit);
  text += headings(labels, format(" %12s %24s %9s", "slope", "95% interval", "direction"));
  for (std::size_t p = 0; p < table.size(); ++p) {
    const cohort::Slope& slope = covariate.slopes[p];
    text += format("    %s %12.4g %24s %8.1f%%\n", labels[p].c_str(), slope.mean,
                   interval_text(slope.interval95).c_str(), 100.0 * slope.direction);
  }
  return text;
}

std::string cohort_text(const cohort::Result& found, const sim::ParameterTable& table) {
  const std::vector<std::string> labels = row_labels(table);
  std::string text = "Groups, hierarchical model: every recording with its whole uncertainty\n";
  for (const cohort::Cell& cell : found.cells) {
    text += "  " + one_line(cell.name()) + ": " + people_text(cell.participants) + "\n";
    text += headings(labels, format(" %12s %24s %14s", "mean", "95% interval", "participant sd"));
    for (std::size_t p = 0; p < table.size(); ++p)
      text += format("    %s %12.5g %24s %14.3g\n", labels[p].c_str(), cell.mean[p].mean,
                     interval_text(cell.mean[p].interval95).c_str(), cell.between_sd[p].mean);
  }
  for (const cohort::Comparison& comparison : found.comparisons) {
    text += "  " + difference_name(found, comparison);
    text +=
        comparison.participants_in_both > 0 ? ", " + people_text(comparison.participants_in_both) + " in both\n" : "\n";
    text += effects_text(comparison.effects, table);
  }
  for (const cohort::Interaction& interaction : found.interactions)
    text += "  (" + difference_name(found, found.comparisons[interaction.first]) + ") minus (" +
            difference_name(found, found.comparisons[interaction.second]) + ")\n" +
            effects_text(interaction.effects, table);
  for (const cohort::Covariate& covariate : found.covariates) text += covariate_text(covariate, table);
  text += format("  %d draws, R-hat at most %.3f. All simultaneous intervals hold together with 95%%.\n", found.draws,
                 found.max_rhat);
  return text;
}

/// Returns the reliability of the pairs of groups that have the same people.
std::string reliability_text(const Report& report, const sim::ParameterTable& table) {
  const GroupComparison& compared = report.groups->comparison;
  const std::vector<std::string> labels = row_labels(table);
  std::string text;
  for (std::size_t i = 0; i < report.groups->reliability.size(); ++i) {
    const auto& of_pair = report.groups->reliability[i];
    if (of_pair.empty()) continue;
    const GroupPair& pair = compared.pairs[i];
    text += "  " + one_line(compared.groups[pair.first].name) + " and " + one_line(compared.groups[pair.second].name) +
            ": " + people_text(pair.participants[0]) + " in both\n" +
            headings(labels, format(" %9s %15s %10s %10s %8s", "ICC(2,1)", "95% interval", "SEM", "MDC", "shown"));
    for (std::size_t p = 0; p < table.size(); ++p) {
      if (!of_pair[p]) continue;
      const cohort::Reliability& found = *of_pair[p];
      const std::string icc_interval =
          std::isnan(found.icc_single95[0])
              ? "-"
              : number_text(found.icc_single95[0], "%.2f") + " to " + number_text(found.icc_single95[1], "%.2f");
      text +=
          format("    %s %9s %15s %10s %10s %8s\n", labels[p].c_str(), number_text(found.icc_single, "%.2f").c_str(),
                 icc_interval.c_str(), number_text(found.standard_error, "%.3g").c_str(),
                 number_text(found.minimal_detectable_change, "%.3g").c_str(),
                 number_text(100.0 * found.shown_fraction, "%.0f%%").c_str());
    }
  }
  if (text.empty()) return text;
  return "Repeated visits: how reliable is a value?\n" + text +
         "  SEM: standard error of measurement. MDC: minimal detectable change of the printed values. These show only "
         "a part\n  of a person's change: decid detects a true change above MDC / shown. -: the data do not determine "
         "it.\n  SEM and MDC include the effect of a treatment between the visits: use the MDC of people who were not "
         "treated.\n";
}

/// Returns how many intervals of persons' changes a call prints, and what their number means.
std::string unadjusted_text(std::size_t people, std::size_t parameters, const char* what) {
  return format("  Above 0: higher in the first-named. The %zu intervals are not adjusted for their number: %s.\n",
                people * parameters, what);
}

/// Returns each person's changes, with a star where both 95% intervals exclude 0; a heading for each comparison.
std::string changes_text(const cohort::Result& found, const sim::ParameterTable& table) {
  if (found.changes.empty()) return {};
  const std::string own = "  own";
  std::size_t width = own.size();
  for (const cohort::Change& change : found.changes)
    width = std::max(width, one_line(found.visits[change.first].participant).size());
  const auto row = [&](std::string name, const auto& cell_of) {
    name.resize(width, ' ');
    std::string text = "    " + name;
    for (std::size_t p = 0; p < table.size(); ++p)  // as wide as its heading
      text += format(" %*s", std::max(12, static_cast<int>(name_and_unit(table[p]).size())), cell_of(p).c_str());
    return text + "\n";
  };
  std::string text =
      "Changes of each person: by the hierarchical model, which borrows from the group's mean change, and below by the "
      "person's\nown recordings only. *: the 95% intervals of both exclude 0; else within measurement error; "
      "intervals: "
      "--json\n" +
      unadjusted_text(found.changes.size(), table.size(), "at most about 1 of 20 has a star by chance");
  for (std::size_t comparison = 0; comparison < found.comparisons.size(); ++comparison) {
    std::string rows;
    for (const cohort::Change& change : found.changes) {
      if (change.comparison != comparison) continue;
      rows += row(one_line(found.visits[change.first].participant), [&](std::size_t p) {
        return format(change.changed(p) ? "*%.3g" : "%.3g", change.difference[p].mean);
      });
      if (!change.own.empty()) rows += row(own, [&](std::size_t p) { return format("%.3g", change.own[p].mean); });
    }
    if (!rows.empty())
      text += "  " + difference_name(found, found.comparisons[comparison]) + "\n" +
              row("", [&](std::size_t p) { return name_and_unit(table[p]); }) + rows;
  }
  return text;
}

/// Returns the changes of people without a hierarchical model: a table for each person.
std::string own_changes_text(const std::vector<cohort::OwnChange>& changes, const sim::ParameterTable& table) {
  if (changes.empty()) return {};
  const std::vector<std::string> labels = row_labels(table);
  std::string text = "Changes of each person, by the uncertainty of this person's recordings only:\n" +
                     unadjusted_text(changes.size(), table.size(), "about 1 of 20 excludes 0 by chance");
  for (const cohort::OwnChange& change : changes) {
    text += "  " + one_line(change.participant) + ": " + one_line(change.first) + " minus " + one_line(change.second) +
            "\n" + headings(labels, format(" %12s %24s", "difference", "95% interval"));
    for (std::size_t p = 0; p < table.size(); ++p)
      text += format("    %s %12.4g %24s  %s\n", labels[p].c_str(), change.difference[p].mean,
                     interval_text(change.difference[p].interval95).c_str(),
                     cohort::excludes_zero(change.difference[p]) ? "changed" : "within measurement error");
    if (change.has_caution) text += "    a recording has a caution: the intervals may be too narrow\n";
  }
  return text;
}

}  // namespace

std::string verdicts_text(const Report& report) {
  const GroupVerdicts verdicts = group_verdicts(report);
  if (verdicts.sentences.empty()) return {};
  std::string text = "What differs? By " + verdicts.intervals + ":\n";
  for (const std::string& note : verdicts.notes) text += "  note: " + note + "\n";
  for (const std::string& sentence : verdicts.sentences) text += "  " + sentence + "\n";
  return text;
}

std::string groups_text(const Report& report) {
  if (!report.groups) return {};
  const GroupComparison& found = report.groups->comparison;
  const std::string& participant_column = report.groups->table.participant_column;
  const sim::ParameterTable parameters = report.compared_parameters();
  std::string text = "Groups: mean +- standard deviation of people\n";
  text += participant_column.empty()
              ? "  No column names the person (participant_id): each recording counts as a person.\n"
              : "  Recordings with the same " + one_line(participant_column) +
                    " are one person's; their mean counts once.\n";
  text += fixed_text(report) + bodies_text(*report.groups);
  for (const Group& group : found.groups) text += group_text(group, parameters);
  for (const GroupPair& pair : found.pairs) text += pair_text(pair, found.groups, parameters);
  const std::string pairs = found.pairs.size() == 1 ? "" : format(" in %zu pairs of groups", found.pairs.size());
  if (!found.pairs.empty())
    text += format(
        "  %zu parameters were compared%s: %zu adjusted intervals (Bonferroni), with a joint coverage of at least "
        "95%%.\n",
        parameters.size(), pairs.c_str(), found.intervals);
  text += reliability_text(report, parameters);
  if (report.groups->hierarchical)
    text +=
        cohort_text(*report.groups->hierarchical, parameters) + changes_text(*report.groups->hierarchical, parameters);
  else
    text += own_changes_text(report.groups->own_changes, parameters);
  return text + without_distribution_text(report) + left_out_text(report);
}

}  // namespace decid::tools
