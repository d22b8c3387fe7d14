// The lines of a report's tables: see table.hpp.
#include <algorithm>
#include <optional>

#include "base/text.hpp"
#include "base/version.hpp"
#include "tools/decid/results/table.hpp"

namespace decid::tools {
namespace {

/// The text, or an empty cell.
Cell text_cell(const std::string& text) {
  return text.empty() ? Cell{} : Cell{text};
}
Cell number_cell(const std::optional<double>& value) {
  return value ? Cell{*value} : Cell{};
}

void append(std::vector<Cell>& row, std::vector<Cell> more) {
  std::ranges::move(more, std::back_inserter(row));
}
void append(std::vector<std::string>& names, const std::vector<std::string>& more) {
  names.insert(names.end(), more.begin(), more.end());
}

/// A parameter's figures in a recording. Limits are empty for point estimates.
struct Figures {
  double value = 0.0;
  std::optional<double> sd = {}, low50 = {}, high50 = {}, low90 = {}, high90 = {};
};

/// Returns the figures of each parameter; empty for a recording with an error.
std::vector<Figures> figures_of(const RecordingResult& id) {
  std::vector<Figures> all;
  if (id.error) return all;
  for (const double value : id.estimate.parameters) all.push_back({value});
  use_distribution(id, [&](const auto& found) {
    for (std::size_t p = 0; p < all.size(); ++p) {
      const int quantity = static_cast<int>(p);
      const auto limit = [&](double fraction, bool upper) {
        const double tail = 0.5 * (1.0 - fraction);
        return found.quantile(quantity, upper ? 1.0 - tail : tail);
      };
      all[p] = {all[p].value,     found.stddev(quantity), limit(0.5, false),
                limit(0.5, true), limit(0.9, false),      limit(0.9, true)};
    }
  });
  return all;
}

std::vector<std::string> who_names(const Report& report) {
  std::vector<std::string> names{"participant_id", "session", "group", "condition"};
  if (report.sheet) append(names, report.sheet->columns);
  return names;
}

/// Adds the names of the person and of the study's columns, which the table copies.
void add_who_names(ResultTable& table, const Report& report) {
  append(table.names, who_names(report));
  table.copied_end = table.names.size();
  table.copied_begin = table.copied_end - (report.sheet ? report.sheet->columns.size() : 0);
}

/// Gives each copied column a name of its own if the table has another column of that name. Programs would rename one
/// of the two, or drop it.
void distinguish(ResultTable& table) {
  std::vector<std::string>& names = table.names;
  for (std::size_t i = table.copied_begin; i < table.copied_end; ++i)
    while (std::ranges::count(names, std::string(names[i])) > 1) names[i] = "sheet_" + names[i];
}

/// The person and the study's columns of recording i; a table of groups counts where the sheet has none.
std::vector<Cell> who_cells(const Report& report, std::size_t i) {
  const SheetEntry& entry = report.recordings[i].entry;
  const GroupMember member = report.groups ? report.groups->table.members.at(i) : GroupMember{};
  const bool has_participant = report.groups && !report.groups->table.participant_column.empty();
  std::vector<Cell> cells{
      text_cell(entry.participant.empty() && has_participant ? member.participant : entry.participant),
      text_cell(entry.session), text_cell(entry.group.empty() ? member.group : entry.group),
      text_cell(entry.condition)};
  for (const std::string& cell : entry.cells) cells.push_back(text_cell(cell));
  return cells;
}

const std::vector<std::string> body_names{"mass_kg", "height_m", "body_mass_kg", "com_height_m", "body_assumed", "mgh"};

/// The person's mass and height by the sheet, and the body above the ankles.
std::vector<Cell> body_cells(const Report& report, const RecordingResult& id) {
  std::vector<Cell> cells{number_cell(id.mass_kg), number_cell(id.height_m)};
  if (id.error) {
    cells.resize(body_names.size());
    return cells;
  }
  const sim::Body& body = report.protocol_for(id).experiment.body;
  const bool assumed = report.setting_of(id).body_assumed;
  append(cells, {body.mass_kg, body.com_height_m, std::string(assumed ? "yes" : "no"), body.mgh()});
  return cells;
}

/// The warnings' codes, the worst first, each once.
std::string codes_of(const RecordingResult& id) {
  std::vector<std::string> seen;
  for (const Warning& warning : id.warnings)
    if (std::ranges::find(seen, warning.code) == seen.end()) seen.push_back(warning.code);
  return joined(seen, " ");
}

const std::vector<std::string> check_names{"codes", "tilt_gain", "response_ratio", "variance_accounted_for"};

std::vector<Cell> check_cells(const RecordingResult& id) {
  if (id.error) return std::vector<Cell>(check_names.size());
  return {text_cell(codes_of(id)), id.trial.tilt ? Cell{id.trial.tilt->gain} : Cell{}, id.explanation.response_ratio,
          id.explanation.variance_accounted_for};
}

const std::vector<std::string> source_names{"protocol", "controller", "model_sha256", "decid", "error"};

std::vector<Cell> source_cells(const Report& report, const RecordingResult& id) {
  if (id.error)
    return {Cell{}, Cell{}, text_cell(report.model_sha256), std::string(version), std::string(id.error->what())};
  const sim::Protocol& protocol = report.protocol_for(id);
  return {protocol.name, protocol.experiment.body_model->name, text_cell(report.model_sha256), std::string(version),
          Cell{}};
}

const posterior::Posterior* posterior_of(const RecordingResult& id) {
  return id.fit ? &id.fit->posterior : nullptr;
}

}  // namespace

ResultTable wide_table(const Report& report) {
  const std::vector<std::string> parameters = report.protocol.parameters().names();
  ResultTable table;
  table.names = {"file", "trust"};
  for (const std::string& name : parameters) append(table.names, {name, name + "_low90", name + "_high90"});
  add_who_names(table, report);
  append(table.names, body_names);
  for (const std::string& name : parameters) append(table.names, {name + "_sd", name + "_normalized"});
  append(table.names, check_names);
  append(table.names, {"max_rhat", "min_effective_draws"});
  append(table.names, source_names);
  distinguish(table);
  for (std::size_t i = 0; i < report.recordings.size(); ++i) {
    const RecordingResult& id = report.recordings[i];
    std::vector<Figures> figures = figures_of(id);
    std::vector<Cell>& row = table.rows.emplace_back();
    append(row, {id.file, id.error ? Cell{} : Cell{std::string(name(id.trust()))}});
    for (std::size_t p = 0; p < parameters.size(); ++p)
      append(row, id.error ? std::vector<Cell>(3)
                           : std::vector<Cell>{figures[p].value, number_cell(figures[p].low90),
                                               number_cell(figures[p].high90)});
    append(row, who_cells(report, i));
    append(row, body_cells(report, id));
    const double mgh = id.error ? 1.0 : report.protocol_for(id).experiment.body.mgh();
    for (std::size_t p = 0; p < parameters.size(); ++p)
      append(row, id.error
                      ? std::vector<Cell>(2)
                      : std::vector<Cell>{number_cell(figures[p].sd), report.protocol.parameters()[p].scales_with_mgh
                                                                          ? Cell{figures[p].value / mgh}
                                                                          : Cell{}});
    append(row, check_cells(id));
    const posterior::Posterior* const found = posterior_of(id);
    const bool has_diagnostics = found != nullptr && !found->rhat().empty();
    append(row, {has_diagnostics ? Cell{std::ranges::max(found->rhat())} : Cell{},
                 has_diagnostics ? Cell{std::ranges::min(found->effective_draws())} : Cell{}});
    append(row, source_cells(report, id));
  }
  return table;
}

ResultTable long_table(const Report& report) {
  const sim::ParameterTable& parameters = report.protocol.parameters();
  ResultTable table;
  table.names = {"file"};
  add_who_names(table, report);
  append(table.names, body_names);
  const std::size_t before = table.names.size();
  append(table.names, {"parameter", "unit", "value", "sd", "low50", "high50", "low90", "high90", "normalized",
                       "normalized_low90", "normalized_high90", "rhat", "effective_draws", "trust"});
  const std::size_t own = table.names.size() - before;
  append(table.names, check_names);
  append(table.names, source_names);
  distinguish(table);
  for (std::size_t i = 0; i < report.recordings.size(); ++i) {
    const RecordingResult& id = report.recordings[i];
    const std::vector<Figures> figures = figures_of(id);
    const posterior::Posterior* const found = posterior_of(id);
    for (std::size_t p = 0; p < std::max<std::size_t>(1, figures.size()); ++p) {
      std::vector<Cell>& row = table.rows.emplace_back();
      append(row, {id.file});
      append(row, who_cells(report, i));
      append(row, body_cells(report, id));
      if (id.error) {
        append(row, std::vector<Cell>(own));
      } else {
        const Figures& of = figures[p];
        const double mgh = report.protocol_for(id).experiment.body.mgh();
        const auto over = [&](const std::optional<double>& value) {
          return parameters[p].scales_with_mgh && value ? Cell{*value / mgh} : Cell{};
        };
        const bool has_diagnostics = found != nullptr && found->rhat().size() > p;
        append(row, {parameters[p].name, parameters[p].unit, of.value, number_cell(of.sd), number_cell(of.low50),
                     number_cell(of.high50), number_cell(of.low90), number_cell(of.high90), over(of.value),
                     over(of.low90), over(of.high90), has_diagnostics ? Cell{found->rhat()[p]} : Cell{},
                     has_diagnostics ? Cell{found->effective_draws()[p]} : Cell{}, std::string(name(id.trust()))});
      }
      append(row, check_cells(id));
      append(row, source_cells(report, id));
    }
  }
  return table;
}

}  // namespace decid::tools
