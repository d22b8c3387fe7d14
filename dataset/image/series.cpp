// Time series as network inputs: block means and their changes.
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/per_thread.hpp"
#include "dataset/image/image.hpp"
#include "dataset/image/kernels/image.hpp"
#include "sim/protocol/stimulus.hpp"

namespace decid::dataset {

// Computes block means of the tilt at the samples, and their rate of change.
void ImageMaker::show_tilt(const sim::Experiment& experiment) {
  if (settings_.block == 0) return;
  const sim::Stimulus stimulus = sim::make_stimulus(experiment);
  const int steps = experiment.steps_per_sample();
  block_s_ = settings_.block / experiment.sample_rate_hz;
  double before = 0.0;
  for (int row = 0; row < rows_; ++row) {
    double sum = 0.0;
    const int first = settings_.first_sample + row * settings_.block;
    for (int sample = first; sample < first + settings_.block; ++sample) sum += stimulus.tilt_at(sample * steps);
    const double tilt = sum / settings_.block;
    if (row == 0) before = tilt;
    tilt_.push_back(static_cast<float>(tilt / tilt_unit_rad));
    tilt_velocity_.push_back(static_cast<float>((tilt - before) / block_s_ / tilt_unit_rad));
    before = tilt;
  }
}

namespace {

/// Replaces values by their differences from the previous value, 0 for the first `known`.
void take_differences(std::vector<double>& of, std::size_t rows, std::size_t known) {
  for (std::size_t row = rows; row-- > 0;) of[row] = row < known ? 0.0 : of[row] - of[row - 1];
}

double knee_of(Channel channel) {
  return channel == Channel::sway_change ? sway_change_knee_rad
         : channel == Channel::sway_bend ? sway_bend_knee_rad
         : channel == Channel::torque    ? torque_knee_rad
                                         : sway_knee_rad;
}

/// Sets means over `block` samples each.
void take_means(std::span<const float> samples, std::size_t block, std::span<double> means) {
  for (std::size_t row = 0; row < means.size(); ++row) {
    double sum = 0.0;
    for (const float sample : samples.subspan(row * block, block)) sum += double{sample};
    means[row] = sum / static_cast<double>(block);
  }
}

/// Replaces the cycles by their mean, and each cycle from the second by its difference from the mean of the earlier
/// ones, times sqrt(k / (k + 1)).
void contrast(std::vector<std::vector<double>>& cycles, std::size_t rows) {
  const auto fold = static_cast<double>(cycles.size());
  for (std::size_t row = 0; row < rows; ++row) {
    double sum = cycles[0][row];
    for (std::size_t k = 1; k < cycles.size(); ++k) {
      const auto before = static_cast<double>(k);
      const double own = cycles[k][row];
      cycles[k][row] = (own - sum / before) * std::sqrt(before / (before + 1.0));
      sum += own;
    }
    cycles[0][row] = sum / fold;
  }
}

}  // namespace

void ImageMaker::make_series(const Sway& sway, std::span<float> image, Isa isa) const {
  const auto rows = static_cast<std::size_t>(rows_), block = static_cast<std::size_t>(settings_.block);
  const auto fold = static_cast<std::size_t>(settings_.fold), window = static_cast<std::size_t>(settings_.window);
  constexpr std::size_t lanes = image_lanes;
  const double per_bend = bend_over_lean_s2_ / (block_s_ * block_s_);
  const std::size_t padded = (rows + lanes - 1) / lanes * lanes;
  struct Scratch {
    std::vector<std::vector<double>> cycles;
    std::vector<double> work;
    std::vector<float> shown;
  };
  Scratch& scratch = per_thread<Scratch>();
  std::vector<std::vector<double>>& cycles = scratch.cycles;
  std::vector<double>& work = scratch.work;
  std::vector<float>& shown = scratch.shown;
  cycles.resize(fold);
  shown.resize(padded);
  const std::span<const float> samples = sway.rad.subspan(static_cast<std::size_t>(settings_.first_sample));
  for (std::size_t cycle = 0; cycle < fold; ++cycle) {
    cycles[cycle].assign(padded, 0.0);
    take_means(samples.subspan(cycle * window), block, std::span(cycles[cycle]).first(rows));
  }
  if (fold > 1) contrast(cycles, rows);
  std::size_t planes = 0;
  const auto next_plane = [&] { return image.subspan(planes++ * rows, rows); };
  for (const Channel channel : settings_.channels) {
    if (channel == Channel::height)
      std::ranges::fill(next_plane(), static_cast<float>((sway.height - 1.0) / height_unit));
    if (channel == Channel::tilt) std::ranges::copy(tilt_, next_plane().begin());
    if (channel == Channel::tilt_velocity) std::ranges::copy(tilt_velocity_, next_plane().begin());
    if (!is_of_sway(channel)) continue;
    for (const std::vector<double>& values : cycles) {
      work = values;
      if (channel == Channel::sway_change) take_differences(work, rows, 1);
      if (channel == Channel::sway_bend || channel == Channel::torque) {
        take_differences(work, rows, 1);
        take_differences(work, rows, 2);
      }
      if (channel == Channel::torque)  // J a'' = m g h a - torque, for the previous block
        for (std::size_t row = rows; row-- > 0;)
          work[row] = row < 2 ? 0.0 : values[row - 1] - sway.height * per_bend * work[row];
      image_kernels(isa).asinh(static_cast<int>(padded), work.data(), knee_of(channel), shown.data());
      std::copy_n(shown.begin(), rows, next_plane().begin());
    }
  }
}

}  // namespace decid::dataset
