// Where truths lie among their posteriors' draws: see calibration_figure.hpp.
#include "tools/report/figures/calibration_figure.hpp"

#include <algorithm>
#include <iterator>
#include <vector>

#include "tools/report/figures/svg.hpp"

namespace decid::tools {

std::string calibration_figure(const sim::ParameterTable& table, std::span<const CalibratedTrial> trials, double band) {
  static constexpr const char* colours[] = {"#17527f", "#e08a3c", "#b3322c", "#4a7d3b",
                                            "#6b4a94", "#8a6d3b", "#2f8f8f"};
  Sheet sheet(760, 420);
  const double limit = std::max(0.3, 1.5 * band);
  Plot plot(sheet, {80, 45}, 650, 310, {"Fraction of the draws below the truth", 0.0, 1.0},
            {"Fraction of the trials, less that", -limit, limit});
  const std::vector<double> ends{0.0, 1.0};
  for (const double edge : {-band, band}) plot.line(ends, std::vector(2, edge), {.colour = "#8593a0", .dashed = true});
  std::vector<std::pair<std::string, std::string>> names;
  for (std::size_t p = 0; p < table.size(); ++p) {
    std::vector<double> below, x{0.0}, y{0.0};
    for (const CalibratedTrial& trial : trials) below.push_back(trial.below[p]);
    std::ranges::sort(below);
    for (std::size_t i = 0; i < below.size(); ++i) {
      for (const std::size_t so_far : {i, i + 1}) {
        x.push_back(below[i]);
        y.push_back(static_cast<double>(so_far) / static_cast<double>(below.size()) - below[i]);
      }
    }
    x.push_back(1.0);
    y.push_back(0.0);
    const std::string colour = colours[p % std::size(colours)];
    plot.line(x, y, {.colour = colour});
    names.emplace_back(table[p].name, colour);
  }
  sheet.legend({80, 22}, names);
  return sheet.svg();
}

}  // namespace decid::tools
