// The network's input: the sway cut into non-overlapping windows, the FFT of each as an image. Rows are frequencies,
// columns are times, and channels are functions of each complex bin (the paper: modulus and phase). Or a time series:
// rows are times, with one column, and channels of sway, tilt and their changes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "dataset/image/channel.hpp"
#include "sim/fft.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::dataset {

/// Returns "modulus", "log_modulus", ...
const char* name(Channel channel);
/// Returns the channel of a name. Throws Error for an unknown name.
Channel channel_from_name(const std::string& name);

/// The longest window, samples.
inline constexpr int max_window = 1 << 17;
/// The maximum number of cycles to average.
inline constexpr int max_fold = 1000;

struct ImageSettings {
  int window = 110;            ///< samples per window
  bool half_spectrum = false;  ///< only rows 0 .. window / 2; the rest mirror them
  std::vector<Channel> channels{Channel::modulus, Channel::phase};
  bool standardize_rows = false;  ///< (value - mean) / sd, with each row's statistics over the training set
  int first_sample = 0;           ///< start of the first window, to skip a lead-in
  /// Cycle averaging: the stimulus plays `fold` equal cycles. z is the mean of the bins with equal tilt, one per cycle,
  /// and log_residual shows their differences. Columns cover one cycle. 1: each window separately.
  int fold = 1;
  int rows = 0;  ///< number of lowest frequencies to keep, needs half_spectrum; 0: all
  /// Above 0: a time series instead of spectra, of means over this many samples; its channels are those of series. With
  /// cycle averaging, `window` is a cycle's length, and each sway channel appears `fold` times: the mean of the cycles,
  /// then their differences (Helmert's contrasts: each cycle minus the mean of the earlier ones, scaled to the standard
  /// deviation of a cycle).
  int block = 0;

  /// Throws Error for a setting out of its bounds, such as max_window.
  void validate() const;
  bool operator==(const ImageSettings&) const = default;
};
/// Returns every setting, as in model files.
std::string to_json(const ImageSettings& settings);
/// Reads settings; missing ones take their defaults. Throws Error, naming `where` and the key, for text that is not
/// JSON, an unknown key, and values that validate() refuses.
ImageSettings image_settings_from_json(const std::string& text, const std::string& where);

struct ImageShape {
  int channels, rows, columns;
  int size() const { return channels * rows * columns; }
};

/// The source of an image: a trial's sway, and its body.
struct Sway {
  std::span<const float> rad;
  double height = 1.0;  ///< body height relative to the experiment's (sim::Body::height_over)

  Sway(std::span<const float> sway_rad, double body_height = 1.0) : rad(sway_rad), height(body_height) {}
  Sway(const std::vector<float>& sway_rad, double body_height = 1.0) : rad(sway_rad), height(body_height) {}
};

/// Makes images of trials of a fixed length. Immutable: all threads may share it.
class ImageMaker {
 public:
  /// samples: length of a trial; a remainder too short for a window or block is ignored. Throws Error if no window or
  /// block fits, or for a channel of the tilt or the torque.
  ImageMaker(ImageSettings settings, int samples);
  /// Makes images of an experiment's trials, with its tilt and body for channels.
  ImageMaker(ImageSettings settings, const sim::Experiment& experiment);

  const ImageSettings& settings() const noexcept { return settings_; }
  ImageShape shape() const noexcept;
  /// Makes an image. sway: of `samples` values. image: shape().size() values, channel-major, rows (frequency) before
  /// columns (time). isa: tests and benchmarks may choose another.
  void make(const Sway& sway, std::span<float> image, Isa isa = chosen_isa()) const;
  /// Makes the images of several trials, one after another, with the same bits as make(). Eight windows are transformed
  /// in parallel. Trials with fewer windows share the lanes, so pass `trials_together` or more at once.
  void make_all(std::span<const Sway> sways, std::span<float> images, Isa isa = chosen_isa()) const;
  int trials_together() const noexcept;

 private:
  ImageMaker(ImageSettings settings, int samples, const sim::Experiment* experiment);
  /// Returns the samples of a time series: of a cycle, or from first_sample to the end.
  int cycle_samples() const noexcept;
  void show_tilt(const sim::Experiment& experiment);
  void make_series(const Sway& sway, std::span<float> image, Isa isa) const;
  /// Computes the spectrum of one window in lane 0.
  void transform_alone(std::span<const float> window, std::span<double> spectrum) const;

  ImageSettings settings_;
  int samples_;
  sim::RealFft fft_;
  int rows_;
  std::vector<float> tilt_, tilt_velocity_;  // as the channels show them
  double bend_over_lean_s2_ = 0.0;           // J / (m g h)
  double block_s_ = 1.0;
};

/// Mean and standard deviation of each row (channel, frequency) over a training set's images and times.
struct RowScaling {
  std::vector<float> mean, stddev;  ///< channels * rows values; standard deviations, 1 where a row is constant

  /// Scales an image row by row: (image - mean) / deviation.
  void apply(std::span<float> image, int columns) const;
};

/// Accumulates row statistics image by image, in double and in call order. The standard deviation divides by N.
class RowStatistics {
 public:
  explicit RowStatistics(ImageShape shape);
  void add(std::span<const float> image);
  RowScaling finish() const;

 private:
  ImageShape shape_;
  long long images_ = 0;
  std::vector<double> mean_, squares_;  // squares: sum of the squared differences from the mean
};

}  // namespace decid::dataset
