// The figure of several controllers: see controllers_figure.hpp.
#include "tools/report/figures/controllers_figure.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "tools/report/json/frf.hpp"

namespace decid::tools {
namespace {

constexpr const char *recorded_colour = "#17527f", *controller_colour = "#e08a3c";

/// A fitted controller's response to a recording.
struct ControllerPanel {
  std::string controller;
  ControllerResponse response;
};

std::vector<ControllerPanel> panels_of(const RecordingResult& recording, const Report& report) {
  std::vector<ControllerPanel> made;
  if (!recording.fit || !recording.fit->compared) return made;
  const auto add = [&](const std::string& controller, const PredictiveCheck& check) {
    ControllerResponse response = controller_response(*recording.fit, check);
    if (!response.frequency_hz.empty()) made.push_back({controller, std::move(response)});
  };
  add(report.protocol_for(recording).experiment.body_model->name, recording.fit->check);
  for (const ControllerFit& other : recording.fit->others) add(other.controller, other.check);
  return made;
}

/// Draws the recorded gain or phase over the controller's band.
void draw_response(Sheet& sheet, Sheet::Point corner, const std::vector<double>& hz,
                   const std::vector<double>& recorded, const posterior::Band& simulated, const PlotAxis& y,
                   const std::string& title) {
  Plot plot(sheet, corner, 330, 190, {"Frequency (Hz)", 0.9 * hz.front(), 1.1 * hz.back(), true}, y, title);
  plot.band(hz, simulated.low, simulated.high, controller_colour);
  plot.line(hz, simulated.middle, {.colour = controller_colour, .dashed = true});
  plot.line(hz, recorded, {.colour = recorded_colour});
  plot.dots(hz, recorded, recorded_colour);
}

/// Returns an axis for the recorded values and the bands of all controllers.
PlotAxis shared_axis(const char* title, const std::vector<ControllerPanel>& panels,
                     std::vector<double> ControllerResponse::*recorded, posterior::Band ControllerResponse::*simulated,
                     bool with_zero) {
  std::vector<std::span<const double>> shown{panels.front().response.*recorded};
  for (const ControllerPanel& panel : panels) {
    shown.emplace_back((panel.response.*simulated).low);
    shown.emplace_back((panel.response.*simulated).high);
  }
  return axis_for(title, shown, with_zero);
}

}  // namespace

std::vector<Figure> controllers_figure(const Report& report, std::span<const ComparedRecording> recordings) {
  constexpr std::size_t max_drawn = 12;
  constexpr double width = 420, height = 540;
  std::vector<std::pair<const RecordingResult*, std::vector<ControllerPanel>>> rows;
  std::size_t columns = 0;
  std::string csv =
      "participant_id,session,group,condition,file,controller,frequency_hz,gain,phase_deg,simulated_gain,gain_low90,"
      "gain_high90,simulated_phase_deg,phase_low90_deg,phase_high90_deg\n";
  for (const ComparedRecording& one : recordings) {
    std::vector<ControllerPanel> panels = panels_of(*one.recording, report);
    if (panels.empty()) continue;
    for (const auto& [controller, response] : panels)
      for (std::size_t i = 0; i < response.frequency_hz.size(); ++i) {
        csv += one.cells + ',' + csv_cell(controller);
        for (const std::vector<double>* values :
             {&response.frequency_hz, &response.gain, &response.phase_deg, &response.simulated_gain.middle,
              &response.simulated_gain.low, &response.simulated_gain.high, &response.simulated_phase_deg.middle,
              &response.simulated_phase_deg.low, &response.simulated_phase_deg.high})
          csv += ',' + Json((*values)[i]).dump();
        csv += '\n';
      }
    columns = std::max(columns, panels.size());
    rows.emplace_back(one.recording, std::move(panels));
  }
  if (rows.empty()) return {};
  const std::size_t drawn = std::min(rows.size(), max_drawn);
  Sheet sheet(40 + width * static_cast<double>(columns), 40 + height * static_cast<double>(drawn));
  sheet.legend({70, 24},
               {{"recorded", recorded_colour}, {"90% of simulated trials, and their median", controller_colour}});
  for (std::size_t row = 0; row < drawn; ++row) {
    const auto& [recording, panels] = rows[row];
    const PlotAxis gain = shared_axis("Gain", panels, &ControllerResponse::gain, &ControllerResponse::simulated_gain,
                                      true),
                   phase = shared_axis("Phase (deg)", panels, &ControllerResponse::phase_deg,
                                       &ControllerResponse::simulated_phase_deg, false);
    const double top = 90 + height * static_cast<double>(row);
    sheet.text({70, top - 28}, recording->file, Anchor::start);
    for (std::size_t k = 0; k < panels.size(); ++k) {
      const ControllerResponse& response = panels[k].response;
      const double left = 70 + width * static_cast<double>(k);
      draw_response(sheet, {left, top}, response.frequency_hz, response.gain, response.simulated_gain, gain,
                    panels[k].controller);
      draw_response(sheet, {left, top + 245}, response.frequency_hz, response.phase_deg, response.simulated_phase_deg,
                    phase, "");
    }
  }
  std::string caption =
      "Gain and phase of sway to tilt: the recorded response, and 90% and the median of trials simulated from each "
      "controller's draws.";
  if (drawn < rows.size()) caption += format(" Drawn: the first %zu of %zu recordings.", drawn, rows.size());
  return {{"controllers", "Frequency responses by controller", caption, sheet.svg(), csv}};
}

}  // namespace decid::tools
