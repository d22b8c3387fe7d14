// Figures of the accuracy of an estimate: see study_figures.hpp.
#include <algorithm>
#include <limits>

#include "base/math/statistics.hpp"
#include "base/text.hpp"
#include "tools/report/figures/study_figures.hpp"

namespace decid::tools {
namespace {

constexpr const char* grey = "#6f7780";

std::string level_colour(std::size_t index) {
  constexpr const char* colours[] = {"#440154", "#3b528b", "#21918c", "#5ec962", "#e0a030", "#b3322c"};
  return colours[std::min<std::size_t>(index, 5)];
}

std::string table(const sim::ParameterTable& parameters, const std::vector<NoiseLevel>& levels,
                  std::vector<Bin> NoiseLevel::*bins, const std::string& unit) {
  std::vector<std::string> header{"sensor_noise_deg", "low" + unit, "high" + unit, "trials", "mse"};
  for (const sim::ParameterInfo& info : parameters) header.push_back("mse_" + info.name);
  header.emplace_back("mean_guess_mse");
  for (const sim::ParameterInfo& info : parameters) header.push_back("mean_guess_mse_" + info.name);
  std::vector<std::vector<double>> columns(header.size());
  for (const NoiseLevel& level : levels)
    for (const Bin& bin : level.*bins) {
      std::vector<double> row{level.sensor_noise_deg, bin.low, bin.high, static_cast<double>(bin.trials),
                              mean(bin.mse)};
      row.insert(row.end(), bin.mse.begin(), bin.mse.end());
      row.push_back(mean(bin.baseline));
      row.insert(row.end(), bin.baseline.begin(), bin.baseline.end());
      for (std::size_t c = 0; c < row.size(); ++c) columns[c].push_back(row[c]);
    }
  return csv(header, columns, 6);
}

/// A panel for each parameter and one for their mean; a line for each level.
std::string panels(const sim::ParameterTable& parameters, const std::vector<NoiseLevel>& levels,
                   std::vector<Bin> NoiseLevel::*bins, const std::string& x) {
  const std::size_t rows = parameters.size() / 4 + 1;
  Sheet sheet(1160, 40 + 300 * static_cast<double>(rows));
  std::vector<std::pair<std::string, std::string>> names;
  for (std::size_t l = 0; l < levels.size(); ++l)
    names.emplace_back(format("%g deg", levels[l].sensor_noise_deg), level_colour(l));
  names.emplace_back("guessing the mean", grey);
  sheet.legend({60, 20}, names);
  const auto value = [&](const Scores& scores, std::size_t panel) {
    return panel < parameters.size() ? scores[panel] : mean(scores);
  };
  const std::vector<Bin>& first = levels.front().*bins;
  const double end = first.back().high;
  for (std::size_t panel = 0; panel <= parameters.size(); ++panel) {
    const std::size_t row = panel / 4, column = panel % 4;
    const Sheet::Point corner{60 + 280 * static_cast<double>(column), 60 + 300 * static_cast<double>(row)};
    const std::string title =
        panel < parameters.size() ? parameters[panel].name : format("Mean of the %zu", parameters.size());
    Plot plot(sheet, corner, 225, 215, {panel / 4 + 1 < rows ? "" : x, 0, end}, {panel % 4 == 0 ? "MSE" : "", 0, 1.5},
              title);
    const auto curve = [&](const std::vector<Bin>& list, const Scores Bin::*scores, const Sheet::Pen& pen) {
      std::vector<double> middles, values;
      for (const Bin& bin : list) {
        middles.push_back((bin.low + bin.high) / 2);
        values.push_back(bin.trials < min_trials_drawn ? std::numeric_limits<double>::quiet_NaN()
                                                       : value(bin.*scores, panel));
      }
      plot.line(middles, values, pen);
      if (!pen.dashed) plot.dots(middles, values, pen.colour);
    };
    curve(first, &Bin::baseline, {grey, 1.4, true});
    for (std::size_t l = 0; l < levels.size(); ++l) curve(levels[l].*bins, &Bin::mse, {level_colour(l), 1.6});
  }
  return sheet.svg();
}

Figure learning_curve(const std::vector<LearningPoint>& points) {
  std::vector<double> trials, mse;
  for (const LearningPoint& p : points) {
    trials.push_back(p.trials);
    mse.push_back(p.mse);
  }
  Sheet sheet(900, 400);
  Plot plot(sheet, {70, 45}, 800, 295, {"Distinct training trials", trials.front() / 1.3, trials.back() * 1.3, true},
            axis_for("MSE", {mse}, true));
  const std::string colour = level_colour(1);
  plot.line(trials, mse, {colour, 2});
  plot.dots(trials, mse, colour);
  return {"learning-curve", "Error over the number of distinct trials", "As measured and given by --learning-curve.",
          sheet.svg(), csv({"trials", "mse"}, {trials, mse}, 9)};
}

}  // namespace

void add_worth_figures(const ModelStudy& study, std::vector<Figure>& figures) {
  const std::string trials = format(
      "%d test trials of seed %llu (uniform parameters, no enrichment), the same at each level of measurement noise. "
      "MSE of the z-scored parameters; the dashed line guesses the training set's mean. Bins of fewer than %d "
      "trials are left out, values above 1.5 stand at the frame's edge; the table has all.",
      study.levels.front().all.trials, static_cast<unsigned long long>(study.fresh_seed), min_trials_drawn);
  figures.push_back(
      {"error-by-amplitude", "Error against the amplitude of sway", trials,
       panels(study.protocol.parameters(), study.levels, &NoiseLevel::by_amplitude_deg, "Peak to peak (deg)"),
       table(study.protocol.parameters(), study.levels, &NoiseLevel::by_amplitude_deg, "_deg")});
  figures.push_back({"error-by-noise", "Error against the vestibular noise Nv", trials,
                     panels(study.protocol.parameters(), study.levels, &NoiseLevel::by_nv, "Nv"),
                     table(study.protocol.parameters(), study.levels, &NoiseLevel::by_nv, "_nv")});
  if (!study.learning_curve.empty()) figures.push_back(learning_curve(study.learning_curve));
}

}  // namespace decid::tools
