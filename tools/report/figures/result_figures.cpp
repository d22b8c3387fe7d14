// Figures of a call's results: see result_figures.hpp.
#include "tools/report/figures/result_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>

#include "base/files/json_object.hpp"
#include "base/math/statistics.hpp"
#include "base/text.hpp"
#include "sim/segments.hpp"
#include "tools/report/figures/controllers_figure.hpp"
#include "tools/report/json/frf.hpp"

namespace decid::tools {
namespace {

constexpr std::array group_colours{"#17527f", "#e08a3c", "#4a7d3b", "#6b4a94", "#b3322c", "#2f8f8f", "#8a6d3b"};
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

std::string colour_of(std::size_t group) {
  return group_colours[group % group_colours.size()];
}

struct Estimates {
  const RecordingResult* recording;
  SheetEntry who;  ///< without cells; participant is the file's name if nobody named the person
  std::vector<double> value, low90, high90;
  std::vector<double> mgh_nm_rad;  ///< of the body that each value is for; NaN: the parameter does not scale with it
};

/// Returns a recording's estimates of the parameters in these places; limits are NaN for point estimates.
Estimates estimates_of(const Report& report, std::size_t i, std::span<const std::size_t> places) {
  const RecordingResult& id = report.recordings[i];
  Estimates made{&id, id.entry, {}, {}, {}, {}};
  if (report.groups && made.who.group.empty()) made.who.group = report.groups->table.members.at(i).group;
  if (report.groups && made.who.participant.empty()) made.who.participant = report.groups->table.members[i].participant;
  if (made.who.participant.empty()) made.who.participant = id.file;
  std::vector<double> scale;  // to the body of the comparison
  for (const std::size_t p : places) {
    const double own = report.protocol_for(id).experiment.body.mgh(),
                 mgh_nm_rad = report.groups ? report.groups->mgh_nm_rad : own;
    scale.push_back(scale_to(mgh_nm_rad, report, id, p) / scale_to(own, report, id, p));
    made.mgh_nm_rad.push_back(report.protocol.parameters()[p].scales_with_mgh ? mgh_nm_rad : unknown);
    made.value.push_back(scale.back() * id.estimate.parameters[p]);
  }
  made.low90.assign(places.size(), unknown);
  made.high90 = made.low90;
  use_distribution(id, [&](const auto& found) {
    for (std::size_t k = 0; k < places.size(); ++k) {
      made.low90[k] = scale[k] * found.quantile(static_cast<int>(places[k]), 0.05);
      made.high90[k] = scale[k] * found.quantile(static_cast<int>(places[k]), 0.95);
    }
  });
  return made;
}

/// Returns the values that occur, in the order of their first recording.
std::vector<std::string> distinct(const std::vector<Estimates>& all, std::string SheetEntry::*member) {
  std::vector<std::string> found;
  for (const Estimates& one : all)
    if (std::ranges::find(found, one.who.*member) == found.end()) found.push_back(one.who.*member);
  return found;
}

std::size_t place_in(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
}

std::string number_text(double value) {
  return std::isfinite(value) ? Json(value).dump() : std::string();
}

std::string cell(const std::string& text) {
  return csv_cell(valid_utf8(text));
}

/// Small plots in rows of four on a sheet.
class Panels {
 public:
  explicit Panels(std::size_t count)
      : rows_((count + columns - 1) / columns), sheet_(4 * width, 40.0 + static_cast<double>(rows_) * height) {}

  Sheet& sheet() { return sheet_; }
  Plot add(PlotAxis x, PlotAxis y, const std::string& title) {
    const auto row_number = next_ / columns;
    const auto column = static_cast<double>(next_ % columns), row = static_cast<double>(row_number);
    ++next_;
    return Plot(sheet_, {62 + column * width, 60 + row * height}, width - 82, height - 70, std::move(x), std::move(y),
                title);
  }

 private:
  static constexpr std::size_t columns = 4;
  static constexpr double width = 260, height = 250;
  std::size_t rows_, next_ = 0;
  Sheet sheet_;
};

/// An axis of names; an empty name shows as "n/a".
PlotAxis axis_of_names(std::vector<std::string> names) {
  for (std::string& name : names)
    if (name.empty()) name = "n/a";
  const double high = static_cast<double>(names.size()) - 0.5;
  return {"", -0.5, high, false, std::move(names)};
}

void add_legend(Sheet& sheet, const std::vector<std::string>& groups) {
  std::vector<std::pair<std::string, std::string>> names;
  for (std::size_t g = 0; g < groups.size(); ++g)
    names.emplace_back(groups[g].empty() ? "all" : groups[g], colour_of(g));
  sheet.legend({62, 24}, names);
}

/// Returns each person's mean of a parameter, in the order of `people`; NaN for a person without one.
std::vector<double> means_of_participants(const std::vector<Estimates>& all,
                                          const std::vector<std::string>& participants, std::size_t p,
                                          const auto& counts) {
  std::vector<std::vector<double>> values(participants.size());
  for (const Estimates& one : all)
    if (counts(one)) values[place_in(participants, one.who.participant)].push_back(one.value[p]);
  std::vector<double> means;
  for (const std::vector<double>& some : values) means.push_back(some.empty() ? unknown : mean(some));
  return means;
}

std::vector<double> finite(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  return values;
}

/// Returns the title of a parameter's axis: its unit, and the m g h that its values are scaled to, if they are.
std::string axis_title(const sim::ParameterInfo& info, const Report& report) {
  const bool is_scaled = report.groups && report.groups->bodies_differ && info.scales_with_mgh;
  return info.shown_unit() + (is_scaled ? ", for m g h " + sim::mgh_text(report.groups->mgh_nm_rad) + " N m/rad" : "");
}

std::string who_cells(const SheetEntry& who) {
  return cell(who.participant) + ',' + cell(who.session) + ',' + cell(who.group) + ',' + cell(who.condition);
}

Figure estimates_figure(const Report& report, const std::vector<Estimates>& all, const sim::ParameterTable& table) {
  const std::vector<std::string> groups = distinct(all, &SheetEntry::group);
  std::vector<std::vector<std::string>> participants(groups.size());
  for (const Estimates& one : all) {
    std::vector<std::string>& of_group = participants[place_in(groups, one.who.group)];
    if (std::ranges::find(of_group, one.who.participant) == of_group.end()) of_group.push_back(one.who.participant);
  }
  Panels panels(table.size());
  std::string csv = "parameter,unit,participant_id,session,group,condition,file,value,low90,high90,mgh\n";
  for (std::size_t p = 0; p < table.size(); ++p) {
    std::vector<double> values;
    for (const Estimates& one : all) values.insert(values.end(), {one.value[p], one.low90[p], one.high90[p]});
    Plot plot =
        panels.add(axis_of_names(groups), axis_for(axis_title(table[p], report), {values}, false), table[p].name);
    for (const Estimates& one : all) {
      const std::size_t g = place_in(groups, one.who.group);
      const double count = static_cast<double>(participants[g].size()),
                   place = static_cast<double>(place_in(participants[g], one.who.participant));
      const std::vector<double> x(2, static_cast<double>(g) + 0.7 * ((place + 0.5) / count - 0.5)),
          interval{one.low90[p], one.high90[p]};
      plot.line(x, interval, {.colour = colour_of(g), .width = 1.0});
      plot.dots(std::span(x).first(1), std::vector{one.value[p]}, colour_of(g));
      csv += cell(table[p].name) + ',' + cell(table[p].unit) + ',' + who_cells(one.who) + ',' +
             cell(one.recording->file) + ',' + number_text(one.value[p]) + ',' + number_text(one.low90[p]) + ',' +
             number_text(one.high90[p]) + ',' + number_text(one.mgh_nm_rad[p]) + '\n';
    }
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const double middle = mean(means_of_participants(
          all, participants[g], p, [&](const Estimates& one) { return one.who.group == groups[g]; }));
      const double at = static_cast<double>(g);
      plot.line(std::vector{at - 0.4, at + 0.4}, std::vector(2, middle), {.colour = "#1c2733", .width = 1.8});
    }
  }
  add_legend(panels.sheet(), groups);
  return {"estimates", "Estimates by group",
          "A dot per recording with its 90% interval, a column per person, and the mean of each group's people.",
          panels.sheet().svg(), csv};
}

/// Draws a line per person over sessions or conditions.
Figure change_figure(const Report& report, const std::vector<Estimates>& all, const sim::ParameterTable& table,
                     const std::string& id, std::string SheetEntry::*visit) {
  const std::vector<std::string> groups = distinct(all, &SheetEntry::group), visits = distinct(all, visit),
                                 participants = distinct(all, &SheetEntry::participant);
  Panels panels(table.size());
  std::string csv = "parameter,unit,participant_id,group," + id.substr(0, id.size() - 1) + ",value,mgh\n";
  const auto mgh_of = [&](std::size_t p, const std::string& group, const std::string& participant,
                          const std::string& name) {  // NaN too for recordings of several bodies
    std::optional<double> found;
    for (const Estimates& one : all) {
      if (one.who.group != group || one.who.participant != participant || one.who.*visit != name) continue;
      if (found && *found != one.mgh_nm_rad[p]) return unknown;
      found = one.mgh_nm_rad[p];
    }
    return found.value_or(unknown);
  };
  std::vector<double> x;
  for (std::size_t v = 0; v < visits.size(); ++v) x.push_back(static_cast<double>(v));
  for (std::size_t p = 0; p < table.size(); ++p) {
    std::vector<std::vector<std::vector<double>>> means(groups.size());  // by visit and person
    std::vector<std::span<const double>> shown;
    for (std::size_t g = 0; g < groups.size(); ++g)
      for (const std::string& name : visits)
        means[g].push_back(means_of_participants(all, participants, p, [&](const Estimates& one) {
          return one.who.group == groups[g] && one.who.*visit == name;
        }));
    for (const auto& of_group : means) shown.insert(shown.end(), of_group.begin(), of_group.end());
    Plot plot = panels.add(axis_of_names(visits), axis_for(axis_title(table[p], report), shown, false), table[p].name);
    for (std::size_t g = 0; g < groups.size(); ++g)
      for (std::size_t participant = 0; participant < participants.size(); ++participant) {
        std::vector<double> y;
        for (std::size_t v = 0; v < visits.size(); ++v) {
          y.push_back(means[g][v][participant]);
          if (std::isfinite(y.back()))
            csv += cell(table[p].name) + ',' + cell(table[p].unit) + ',' + cell(participants[participant]) + ',' +
                   cell(groups[g]) + ',' + cell(visits[v]) + ',' + number_text(y.back()) + ',' +
                   number_text(mgh_of(p, groups[g], participants[participant], visits[v])) + '\n';
        }
        plot.line(x, y, {.colour = colour_of(g), .width = 1.0});
        plot.dots(x, y, colour_of(g));
      }
  }
  add_legend(panels.sheet(), groups);
  return {id, "Change by " + id.substr(0, id.size() - 1), "A line per person through the means of the recordings.",
          panels.sheet().svg(), csv};
}

/// A recording's response: gains, and phases in degrees near those of the identified controller's linear loop.
struct Response {
  std::size_t group = 0;
  std::vector<double> gain, phase_deg;
};

Response response_of(const FrequencyResponses& frf, std::size_t group) {
  Response made{group, {}, {}};
  double linear_deg = 0.0;  // unwrapped from band to band: noise would mislead the recording's own phase
  for (std::size_t k = 0; k < frf.recorded.size(); ++k) {
    linear_deg = bode({.response = frf.linear[k]}, linear_deg).phase_deg;
    const Bode figures = bode(frf.recorded[k], linear_deg);
    made.gain.push_back(figures.gain);
    made.phase_deg.push_back(figures.phase_deg);
  }
  return made;
}

/// Draws the median of a group's recordings, and their quartiles dashed.
void draw_band(Plot& plot, const std::vector<double>& x, const std::vector<Response>& all, std::size_t group,
               std::vector<double> Response::*figure) {
  for (const double fraction : {0.25, 0.5, 0.75}) {
    std::vector<double> y;
    for (std::size_t k = 0; k < x.size(); ++k) {
      std::vector<double> values;
      for (const Response& one : all)
        if (one.group == group) values.push_back((one.*figure)[k]);
      values = finite(std::move(values));
      y.push_back(values.empty() ? unknown : quantile(std::move(values), fraction));
    }
    const bool is_median = fraction == 0.5;
    plot.line(x, y, {.colour = colour_of(group), .width = is_median ? 2.0 : 1.0, .dashed = !is_median});
  }
}

std::vector<Figure> response_figure(const std::vector<Estimates>& all) {
  const std::vector<std::string> groups = distinct(all, &SheetEntry::group);
  std::vector<double> hz;
  std::vector<Response> responses;
  std::string csv = "participant_id,session,group,condition,file,frequency_hz,gain,phase_deg\n";
  for (const Estimates& one : all) {
    const std::optional<FrequencyResponses>& frf = one.recording->explanation.frf;
    if (!frf || frf->recorded.empty()) continue;
    std::vector<double> own;
    for (const sim::FrfPoint& point : frf->recorded) own.push_back(point.frequency_hz);
    if (hz.empty()) hz = own;
    if (own != hz) continue;
    const Response& added = responses.emplace_back(response_of(*frf, place_in(groups, one.who.group)));
    for (std::size_t k = 0; k < hz.size(); ++k)
      csv += who_cells(one.who) + ',' + cell(one.recording->file) + ',' + number_text(hz[k]) + ',' +
             number_text(added.gain[k]) + ',' + number_text(added.phase_deg[k]) + '\n';
  }
  if (responses.empty()) return {};
  std::vector<std::span<const double>> gains, phases;
  for (const Response& one : responses) {
    gains.emplace_back(one.gain);
    phases.emplace_back(one.phase_deg);
  }
  Sheet sheet(900, 400);
  const PlotAxis x{"Frequency (Hz)", 0.9 * hz.front(), 1.1 * hz.back(), true};
  Plot gain(sheet, {70, 50}, 360, 290, x, axis_for("Gain", gains, true)),
      phase(sheet, {520, 50}, 360, 290, x, axis_for("Phase (deg)", phases, false));
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (std::ranges::find(responses, g, &Response::group) == responses.end()) continue;
    draw_band(gain, hz, responses, g, &Response::gain);
    draw_band(phase, hz, responses, g, &Response::phase_deg);
  }
  add_legend(sheet, groups);
  return {{"responses", "Frequency responses by group",
           "Gain and phase of sway to tilt: median of the recordings, and dashed their quartiles.", sheet.svg(), csv}};
}

}  // namespace

std::vector<Figure> result_figures(const Report& report) {
  const std::vector<std::size_t> places = report.inferred_parameters();  // a fixed one is no estimate
  std::vector<Estimates> all;
  std::vector<ComparedRecording> compared;
  for (std::size_t i = 0; i < report.recordings.size(); ++i) {
    const RecordingResult& recording = report.recordings[i];
    if (recording.error) continue;
    if (recording.trust() != Trust::not_usable) all.push_back(estimates_of(report, i, places));
    if (recording.fit && recording.fit->compared)
      compared.push_back({&recording, who_cells(estimates_of(report, i, places).who) + ',' + cell(recording.file)});
  }
  if (all.empty()) return controllers_figure(report, compared);
  std::vector<Figure> figures;
  if (!places.empty()) {
    const sim::ParameterTable table = report.compared_parameters();
    figures.push_back(estimates_figure(report, all, table));
    if (distinct(all, &SheetEntry::session).size() > 1)
      figures.push_back(change_figure(report, all, table, "sessions", &SheetEntry::session));
    if (distinct(all, &SheetEntry::condition).size() > 1)
      figures.push_back(change_figure(report, all, table, "conditions", &SheetEntry::condition));
  }
  if (report.groups && report.groups->bodies_differ)
    for (Figure& figure : figures)
      figure.caption +=
          " Stiffness and damping are scaled to one body, of m g h = " + sim::mgh_text(report.groups->mgh_nm_rad) +
          " N m/rad.";
  for (Figure& figure : response_figure(all)) figures.push_back(std::move(figure));
  for (Figure& figure : controllers_figure(report, compared)) figures.push_back(std::move(figure));
  return figures;
}

}  // namespace decid::tools
