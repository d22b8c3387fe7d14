// Time series as images: means of blocks, and how they change.
#include <algorithm>
#include <vector>

#include "dataset/image/image.hpp"
#include "dataset/image/kernels/image.hpp"
#include "sim/stimulus.hpp"

namespace decid::dataset {

// Means over blocks of the tilt at the samples, and how fast these change.
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

void ImageMaker::make_series(const Sway& sway, std::span<float> image, Isa isa) const {
  const auto rows = static_cast<std::size_t>(rows_), block = static_cast<std::size_t>(settings_.block);
  constexpr std::size_t lanes = image_lanes;
  const double per_bend = bend_over_lean_s2_ / (block_s_ * block_s_);
  const std::size_t padded = (rows + lanes - 1) / lanes * lanes;
  thread_local std::vector<double> values, work;
  thread_local std::vector<float> shown;
  values.assign(padded, 0.0);
  shown.resize(padded);
  for (std::size_t row = 0; row < rows; ++row) {
    const float* sample = sway.rad.data() + static_cast<std::size_t>(settings_.first_sample) + row * block;
    double sum = 0.0;
    for (std::size_t i = 0; i < block; ++i) sum += double{sample[i]};
    values[row] = sum / static_cast<double>(block);
  }
  const auto draw = [&](const std::vector<double>& of, double knee, std::span<float> plane) {
    image_kernels(isa).asinh(static_cast<int>(padded), of.data(), knee, shown.data());
    std::copy_n(shown.begin(), rows, plane.begin());
  };
  // The difference from the value before, 0 for the first `known`.
  const auto differences = [&](std::vector<double>& of, std::size_t known) {
    for (std::size_t row = rows; row-- > 0;) of[row] = row < known ? 0.0 : of[row] - of[row - 1];
  };
  for (std::size_t c = 0; c < settings_.channels.size(); ++c) {
    const std::span<float> plane = image.subspan(c * rows, rows);
    work = values;
    switch (settings_.channels[c]) {
      case Channel::sway_change:
        differences(work, 1);
        draw(work, sway_change_knee_rad, plane);
        break;
      case Channel::sway_bend:
        differences(work, 1);
        differences(work, 2);
        draw(work, sway_bend_knee_rad, plane);
        break;
      case Channel::torque:
        // J a'' = m g h a - torque, about the block before.
        differences(work, 1);
        differences(work, 2);
        for (std::size_t row = rows; row-- > 0;)
          work[row] = row < 2 ? 0.0 : values[row - 1] - sway.height * per_bend * work[row];
        draw(work, torque_knee_rad, plane);
        break;
      case Channel::height:
        std::ranges::fill(plane, static_cast<float>((sway.height - 1.0) / height_unit));
        break;
      case Channel::tilt:
        std::copy(tilt_.begin(), tilt_.end(), plane.begin());
        break;
      case Channel::tilt_velocity:
        std::copy(tilt_velocity_.begin(), tilt_velocity_.end(), plane.begin());
        break;
      default:
        draw(work, sway_knee_rad, plane);
    }
  }
}

}  // namespace decid::dataset
