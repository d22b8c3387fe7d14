// The figures of the paper: see study_figures.hpp. study_worth.cpp draws what an estimate is worth.
#include "tools/report/figures/study_figures.hpp"

#include <algorithm>
#include <cmath>

#include "base/math/statistics.hpp"
#include "base/text.hpp"
#include "dataset/image/channel.hpp"
#include "dataset/image/image.hpp"

namespace decid::tools {
namespace {

constexpr const char* blue = "#17527f";
constexpr const char* orange = "#e08a3c";
constexpr const char* red = "#b3322c";

std::vector<double> in_degrees(std::span<const float> angles) {
  std::vector<double> degrees;
  for (const float angle : angles) degrees.push_back(static_cast<double>(angle) / sim::rad_per_deg);
  return degrees;
}

/// Limits of the colour scale: a few values lie far beyond the others.
std::pair<double, double> usual_range(std::vector<double> values) {
  std::ranges::sort(values);
  const double low = quantile_of_sorted(values, 0.005), high = quantile_of_sorted(values, 0.995);
  return {low, high > low ? high : low + 1};
}

std::uint8_t shade(double value, std::pair<double, double> range) {
  return static_cast<std::uint8_t>(
      std::lround(255 * std::clamp((value - range.first) / (range.second - range.first), 0.0, 1.0)));
}

Figure amplitude_histogram(const StudyData& data) {
  const auto& before = data.before.peak_to_peak;
  const auto& all = data.all.peak_to_peak;
  const double width = (all.high() - all.low()) / static_cast<double>(all.bins().size());
  std::vector<std::vector<double>> columns(4);
  for (std::size_t i = 0; i < all.bins().size(); ++i) {
    columns[0].push_back(all.low() + width * static_cast<double>(i));
    columns[1].push_back(all.low() + width * static_cast<double>(i + 1));
    columns[2].push_back(static_cast<double>(before.bins()[i]));
    columns[3].push_back(static_cast<double>(all.bins()[i]));
  }
  Sheet sheet(900, 400);
  Plot plot(sheet, {70, 45}, 800, 295, {"Peak-to-peak sway (rad)", all.low(), all.high()},
            axis_for("Trials", {columns[3]}, true));
  for (std::size_t i = 0; i < columns[0].size(); ++i) plot.bar(columns[0][i], columns[1][i], columns[3][i], orange);
  for (std::size_t i = 0; i < columns[0].size(); ++i) plot.bar(columns[0][i], columns[1][i], columns[2][i], blue);
  plot.upright(dataset::parent_peak_to_peak_rad, "parents of the enrichment", red);
  sheet.legend({75, 22}, {{"before enrichment", blue}, {"after", orange}});
  return {
      "amplitude-histogram", "Sway before and after enrichment",
      format("Peak-to-peak sway of the %lld trials, and of the %lld that were there before enrichment, which stand in "
             "front. Trials right of the dashed line are its parents.",
             all.count(), before.count()),
      sheet.svg(), csv({"low_rad", "high_rad", "before", "after"}, columns, 6)};
}

/// Plots the network input of a time series, one plot per plane. The sway has one plane per cycle: the mean of the
/// cycles, then the difference of each cycle from those before it.
Figure input_series(const ModelStudy& study) {
  const dataset::ImageShape& shape = study.sample.image_shape;
  const auto rows = static_cast<std::size_t>(shape.rows);
  const double block_s = study.image.block / study.protocol.experiment.sample_rate_hz;
  std::vector<std::string> header{"time_s"};
  for (const dataset::Channel channel : study.image.channels) {
    const bool folded = dataset::is_of_sway(channel) && study.image.fold > 1;
    header.push_back(dataset::name(channel) + std::string(folded ? "_mean" : ""));
    for (int cycle = 2; folded && cycle <= study.image.fold; ++cycle)
      header.push_back(dataset::name(channel) + format("_difference_%d", cycle));
  }
  std::vector<std::vector<double>> columns(header.size());
  for (std::size_t row = 0; row < rows; ++row) columns[0].push_back(static_cast<double>(row) * block_s);
  const double width = 395, height = 150, step_x = width + 70, step_y = height + 75;
  const std::size_t rows_of_plots = header.size() / 2;
  Sheet sheet(2 * step_x + 20, step_y * static_cast<double>(rows_of_plots) + 20);
  for (std::size_t plane = 1; plane < header.size(); ++plane) {
    for (std::size_t row = 0; row < rows; ++row)
      columns[plane].push_back(static_cast<double>(study.sample.image[(plane - 1) * rows + row]));
    const std::size_t across = (plane - 1) % 2, down = (plane - 1) / 2;
    Plot plot(sheet, {60 + step_x * static_cast<double>(across), 35 + step_y * static_cast<double>(down)}, width,
              height, {"Time (s)", 0, columns[0].back()}, axis_for("", {columns[plane]}, false), header[plane]);
    plot.line(columns[0], columns[plane], {blue, 1});
  }
  return {"input-image", "Network input",
          format("Trial %d of the %s as the network's %d time series of %d values, each the mean of %d samples; of the "
                 "sway the cycles' mean, then how each differs from those before it.",
                 study.sample.index, study.sample.from.c_str(), shape.channels, shape.rows, study.image.block),
          sheet.svg(), csv(header, columns, 7)};
}

/// Frequency upwards, as far as it is not a mirror image.
Figure input_image(const ModelStudy& study) {
  const dataset::ImageShape& shape = study.sample.image_shape;
  const auto channels = static_cast<std::size_t>(shape.channels);
  const auto plane = static_cast<std::size_t>(shape.rows) * static_cast<std::size_t>(shape.columns);
  std::vector<std::vector<double>> columns(2 + channels);
  std::vector<std::string> header{"frequency_row", "time_column"};
  for (std::size_t i = 0; i < plane; ++i) {
    const std::size_t row = i / static_cast<std::size_t>(shape.columns);
    columns[0].push_back(static_cast<double>(row));
    columns[1].push_back(static_cast<double>(i % static_cast<std::size_t>(shape.columns)));
  }
  std::vector<Bitmap> maps;
  Bitmap both(shape.columns, shape.rows, 3, 0);
  for (std::size_t c = 0; c < channels; ++c) {
    header.emplace_back(dataset::name(study.image.channels[c]));
    std::vector<double>& values = columns[2 + c];
    for (std::size_t i = 0; i < plane; ++i) values.push_back(static_cast<double>(study.sample.image[c * plane + i]));
    std::vector<double> shown = values;
    if (study.image.channels[c] == dataset::Channel::modulus)
      for (double& v : shown) v = std::log(std::max(v, dataset::min_modulus_rad));
    const auto range = usual_range(shown);
    maps.emplace_back(shape.columns, shape.rows, 1);
    for (std::size_t i = 0; i < plane; ++i) {
      const int row = shape.rows - 1 - static_cast<int>(columns[0][i]), column = static_cast<int>(columns[1][i]);
      maps.back().at(row, column) = shade(shown[i], range);
      if (c < 2) both.at(row, column, static_cast<int>(c)) = shade(shown[i], range);
    }
  }
  const bool as_paper = channels == 2;
  const double side = 330, step = side + 75;
  const std::size_t panels = channels + (as_paper ? 1 : 0);
  Sheet sheet(step * static_cast<double>(panels) + 20, side + 95);
  const double rate = study.protocol.experiment.sample_rate_hz, window = study.image.window;
  const auto panel = [&](std::size_t index, const Bitmap& map, const std::string& title) {
    const Sheet::Point corner{65 + step * static_cast<double>(index), 35};
    const Plot axes(sheet, corner, side, side, {"Time (s)", 0, shape.columns * window / rate},
                    {index == 0 ? "Frequency (Hz)" : "", 0, shape.rows * rate / window}, title);
    sheet.bitmap(corner, side, side, map);
  };
  if (as_paper) panel(0, both, "Both: red and green");
  for (std::size_t c = 0; c < channels; ++c) panel(c + (as_paper ? 1 : 0), maps[c], header[2 + c]);
  return {
      "input-image", "An input image",
      format("Trial %d of the %s as the network's %d x %d image of %d channels: the FFT of windows of %d samples, one "
             "a column. A modulus is shown by its logarithm; the colours end where the outermost half a percent "
             "begins.",
             study.sample.index, study.sample.from.c_str(), shape.rows, shape.columns, shape.channels,
             study.image.window),
      sheet.svg(), csv(header, columns, 7)};
}

/// Draws activations of one column, a line of pixels for each filter: tiles would be thousands of lines high.
Figure activation_lines(const ModelStudy& study) {
  const nn::Shape& shape = study.sample.activation_shape;
  Bitmap map(shape.rows, shape.channels, 1);
  std::vector<std::vector<double>> columns;
  std::vector<std::string> header;
  const auto rows = static_cast<std::size_t>(shape.rows);
  for (int c = 0; c < shape.channels; ++c) {
    header.push_back("filter_" + std::to_string(c + 1));
    const auto values = std::span(study.sample.activation).subspan(static_cast<std::size_t>(c) * rows, rows);
    columns.emplace_back(values.begin(), values.end());
    const auto range = usual_range(columns.back());
    for (std::size_t row = 0; row < rows; ++row) map.at(c, static_cast<int>(row)) = shade(columns.back()[row], range);
  }
  const double height = 8.0 * shape.channels;
  Sheet sheet(900, 20 + height);
  sheet.bitmap({10, 10}, 880, height, map);
  return {
      "activations", "First layer's activations",
      format("Response of each of the %d filters of the first layer (%s) to what is above, BatchNorm included, before "
             "ReLU; a line each, lighter is larger, each with a scale of its own. %s to the right.",
             shape.channels, study.sample.activation_layer.c_str(), study.image.block > 0 ? "Time" : "Frequency"),
      sheet.svg(), csv(header, columns, 5)};
}

Figure activations(const ModelStudy& study) {
  const nn::Shape& shape = study.sample.activation_shape;
  if (shape.columns == 1) return activation_lines(study);
  const int side = static_cast<int>(std::ceil(std::sqrt(shape.channels))), gap = 3;
  const int lines = (shape.channels + side - 1) / side;
  const auto plane = static_cast<std::size_t>(shape.rows * shape.columns);
  Bitmap tiles(side * (shape.columns + gap) - gap, lines * (shape.rows + gap) - gap, 1);
  std::vector<std::vector<double>> columns;
  std::vector<std::string> header;
  for (int c = 0; c < shape.channels; ++c) {
    header.push_back("filter_" + std::to_string(c + 1));
    const auto values = std::span(study.sample.activation).subspan(static_cast<std::size_t>(c) * plane, plane);
    columns.emplace_back(values.begin(), values.end());
    const auto range = usual_range(columns.back());
    for (int row = 0; row < shape.rows; ++row)
      for (int column = 0; column < shape.columns; ++column)
        tiles.at(c / side * (shape.rows + gap) + shape.rows - 1 - row, c % side * (shape.columns + gap) + column) =
            shade(columns.back()[static_cast<std::size_t>(row * shape.columns + column)], range);
  }
  const double scale = 880.0 / tiles.width;
  Sheet sheet(900, 20 + scale * tiles.height);
  sheet.bitmap({10, 10}, 880, scale * tiles.height, tiles);
  return {
      "activations", "First layer's activations",
      format("Response of each of the %d filters of the first layer (%s) to the image above, BatchNorm included, "
             "before ReLU; %d x %d grid, lighter is larger, each filter with a scale of its own. Frequency upwards, "
             "time to the right.",
             shape.channels, study.sample.activation_layer.c_str(), lines, side),
      sheet.svg(), csv(header, columns, 5)};
}

Figure loss(const ModelStudy& study) {
  std::vector<double> epoch, training, validation;
  for (const EpochLog& e : study.log) {
    epoch.push_back(e.epoch);
    training.push_back(e.training_mse);
    validation.push_back(e.validation_mse);
  }
  Sheet sheet(900, 400);
  Plot plot(sheet, {70, 45}, 800, 295, {"Epoch", 0, std::max(epoch.back(), 2.0)},
            axis_for("MSE", {training, validation}, true));
  plot.line(epoch, training, {blue, 2});
  plot.line(epoch, validation, {orange, 2});
  plot.dots(epoch, training, blue);
  plot.dots(epoch, validation, orange);
  sheet.legend({75, 22}, {{"training", blue}, {"validation", orange}});
  const EpochLog& best = study.log.at(static_cast<std::size_t>(best_epoch(study.log)) - 1);
  return {
      "loss", "Training and validation loss",
      format("Mean squared error of the %zu z-scored parameters: of the training half's batches as they were trained, "
             "and of the validation half after each epoch. Least validation MSE %.4f in epoch %d of %zu.",
             study.protocol.parameters().size(), best.validation_mse, best.epoch, study.log.size()),
      sheet.svg(), log_csv(study.log, study.protocol.parameters().size())};
}

/// Above: z-scored parameters side by side. Below: sways.
std::string parameters_and_sway(const sim::Protocol& protocol,
                                const std::vector<std::pair<std::string, const Scores*>>& bars,
                                const std::vector<std::pair<std::string, std::vector<double>>>& sways) {
  const std::vector<const char*> colours{blue, orange};
  std::vector<std::span<const double>> all;
  std::vector<std::pair<std::string, std::string>> bar_names, sway_names;
  Sheet sheet(900, 720);
  const sim::ParameterTable& table = protocol.parameters();
  for (const auto& bar : bars) all.emplace_back(*bar.second);
  Plot scores(sheet, {70, 45}, 800, 255, {"", -0.6, static_cast<double>(table.size()) - 0.4, false, table.names()},
              axis_for("z-score", all, true));
  const double width = 0.7 / static_cast<double>(bars.size());
  for (std::size_t b = 0; b < bars.size(); ++b) {
    bar_names.emplace_back(bars[b].first, colours[b]);
    for (std::size_t p = 0; p < table.size(); ++p) {
      const double left = static_cast<double>(p) - 0.35 + width * static_cast<double>(b);
      scores.bar(left, left + width, (*bars[b].second)[p], colours[b]);
    }
  }
  sheet.legend({75, 22}, bar_names);

  all.clear();
  std::vector<double> time(sways.front().second.size());
  for (std::size_t k = 0; k < time.size(); ++k) time[k] = static_cast<double>(k) / protocol.experiment.sample_rate_hz;
  for (const auto& sway : sways) all.emplace_back(sway.second);
  Plot plot(sheet, {70, 390}, 800, 270, {"Time (s)", 0, time.back()}, axis_for("Sway (deg)", all, false));
  for (std::size_t s = 0; s < sways.size(); ++s) {
    sway_names.emplace_back(sways[s].first, colours[s]);
    plot.signal(time, sways[s].second, {colours[s], 1.2});
  }
  sheet.legend({75, 370}, sway_names);
  return sheet.svg();
}

std::string sway_csv(const std::vector<std::string>& names, std::vector<std::vector<double>> sways, double rate_hz) {
  std::vector<double> time(sways.front().size());
  for (std::size_t k = 0; k < time.size(); ++k) time[k] = static_cast<double>(k) / rate_hz;
  for (std::vector<double>& sway : sways) sway.resize(time.size(), std::nan(""));
  sways.insert(sways.begin(), time);
  std::vector<std::string> header{"time"};
  header.insert(header.end(), names.begin(), names.end());
  return csv(header, sways, 8);
}

Figure known(const ModelStudy& study, const KnownTrial& trial, const std::string& id, const std::string& title,
             const std::string& target, const std::string& sway, const std::string& caption) {
  const std::string simulated = "simulated from the identified parameters, noise-free";
  const auto recorded = in_degrees(trial.sway_rad), fitted = in_degrees(trial.fitted_rad);
  const double rate = study.protocol.experiment.sample_rate_hz;
  return {id, title,
          caption + format(" Squared error, the sum over the %zu: %.4f; their mean: %.4f.", trial.target.size(),
                           trial.squared_error(), trial.squared_error() / static_cast<double>(trial.target.size())),
          parameters_and_sway(study.protocol, {{target, &trial.target}, {"identified", &trial.output}},
                              {{sway, recorded}, {simulated, fitted}}),
          sway_csv({"sway_deg", "simulated_deg"}, {recorded, fitted}, rate)};
}

}  // namespace

std::vector<Figure> study_figures(const ModelStudy& study) {
  std::vector<Figure> figures;
  if (study.data) figures.push_back(amplitude_histogram(*study.data));
  figures.push_back(study.image.block > 0 ? input_series(study) : input_image(study));
  figures.push_back(activations(study));
  if (!study.log.empty()) figures.push_back(loss(study));
  figures.push_back(
      known(study, study.sample.trial, "sample", "An identified sample", "target", "sway of the trial",
            format("Trial %d of the %s, the one with the median squared error: half of them are identified "
                   "better, half worse.",
                   study.sample.index, study.sample.from.c_str())));
  if (study.dip) {
    double sum = 0;
    for (const double error : study.dip->squared_errors) sum += error;
    figures.push_back(known(
        study, study.dip->trial, "double-pendulum", "The double inverted pendulum", "ankle of the double pendulum",
        "centre of mass of the double pendulum",
        format("Leg and trunk with default parameters, identified as if they were one body: the identified "
               "parameters beside those of the ankle, and the sway of both. Mean squared error of %zu realisations "
               "of the noise: %.4f.",
               study.dip->squared_errors.size(), sum / static_cast<double>(study.dip->squared_errors.size()))));
  }
  if (study.recording) {
    const RecordingResult& id = *study.recording;
    const auto recorded = in_degrees(id.trial.sway_rad()), fitted = in_degrees(id.explanation.fitted_rad);
    figures.push_back(
        {"recording", "A recording",
         format("%s: identified parameters (z-scores of the training set), and its sway, %.4f degrees peak "
                "to peak, beside that simulated from them without noise.",
                id.file.c_str(), id.peak_to_peak_deg()),
         parameters_and_sway(study.protocol, {{"identified", &study.recording_output}},
                             {{"recorded", recorded}, {"simulated, noise-free", fitted}}),
         sway_csv({"sway_deg", "simulated_deg"}, {recorded, fitted}, study.protocol.experiment.sample_rate_hz)});
  }
  add_worth_figures(study, figures);
  return figures;
}

}  // namespace decid::tools
