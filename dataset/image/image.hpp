// The network's input: the sway cut into non-overlapping windows, the FFT of each as an image. Rows are frequency,
// columns time, channels what is drawn of each complex bin (the paper: modulus and phase). Or a time series: rows are
// time, one column, channels sway and tilt and how they change.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "dataset/image/channel.hpp"
#include "sim/fft.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::dataset {

/// "modulus", "log_modulus", ...
const char* name(Channel channel);
/// Throws Error for an unknown name.
Channel channel_from_name(const std::string& name);

/// The longest window, samples.
inline constexpr int max_window = 1 << 17;
/// The most cycles that can be folded.
inline constexpr int max_fold = 1000;

struct ImageSettings {
  int window = 110;            ///< samples a window
  bool half_spectrum = false;  ///< rows 0 .. window / 2 only; the rest mirror them
  std::vector<Channel> channels{Channel::modulus, Channel::phase};
  bool standardize_rows = false;  ///< (value - mean) / deviation, with each row's figures over the training set
  int first_sample = 0;           ///< where the first window starts, to skip a lead-in
  /// The stimulus plays `fold` equal cycles: z is the mean of the bins that see the same tilt, one from each cycle, and
  /// log_residual shows how they differ. Columns cover one cycle. 1: each window by itself.
  int fold = 1;
  int rows = 0;  ///< only this many of the lowest frequencies, needs half_spectrum; 0: all
  /// Above 0: in place of spectra a time series, of means of so many samples; its channels are those of series. With a
  /// fold, `window` is a cycle's length, and each channel of the sway is as many: of the cycles' mean, then of how they
  /// differ (Helmert's contrasts: each cycle from the mean of those before it, scaled to the deviation of a cycle).
  int block = 0;

  /// Throws Error for a setting out of its bounds; max_window is one of them.
  void validate() const;
  bool operator==(const ImageSettings&) const = default;
};
/// Every setting, as in model files.
std::string to_json(const ImageSettings& settings);
/// The settings in such a text; those that it leaves out are the defaults. Throws Error, naming `where` and the key,
/// for text that is not JSON, a key that is not known, and what validate() refuses.
ImageSettings image_settings_from_json(const std::string& text, const std::string& where);

struct ImageShape {
  int channels, rows, columns;
  int size() const { return channels * rows * columns; }
};

/// What an image is made of: a trial's sway, and the body that swayed.
struct Sway {
  std::span<const float> rad;
  double height = 1.0;  ///< of the body over that of the experiment's (sim::Body::height_over)

  Sway(std::span<const float> sway_rad, double body_height = 1.0) : rad(sway_rad), height(body_height) {}
  Sway(const std::vector<float>& sway_rad, double body_height = 1.0) : rad(sway_rad), height(body_height) {}
};

/// Makes images of trials of a fixed length; immutable, one serves all threads.
class ImageMaker {
 public:
  /// samples: length of a trial; what is too short for a window or block at its end is left out.
  /// Throws Error if no window or block fits, or for a channel of the tilt or the torque.
  ImageMaker(ImageSettings settings, int samples);
  /// Of an experiment's trials, whose tilt and body channels may show.
  ImageMaker(ImageSettings settings, const sim::Experiment& experiment);

  const ImageSettings& settings() const noexcept { return settings_; }
  ImageShape shape() const noexcept;
  /// sway: of `samples` values. image: shape().size() values, channel-major, rows (frequency) before columns (time).
  /// isa: tests and benchmarks may ask for another.
  void make(const Sway& sway, std::span<float> image, Isa isa = chosen_isa()) const;
  /// The images of several trials, one after another, each with the bits that it has alone. Eight windows are
  /// transformed side by side: trials that have fewer share the lanes, so give `trials_together` at once, or many.
  void make_all(std::span<const Sway> sways, std::span<float> images, Isa isa = chosen_isa()) const;
  int trials_together() const noexcept;

 private:
  ImageMaker(ImageSettings settings, int samples, const sim::Experiment* experiment);
  /// Of a time series: of a cycle, or from first_sample to the end.
  int cycle_samples() const noexcept;
  void show_tilt(const sim::Experiment& experiment);
  void make_series(const Sway& sway, std::span<float> image, Isa isa) const;
  /// The spectrum of one window in lane 0.
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
  std::vector<float> mean, deviation;  ///< channels * rows values; deviation is 1 where a row is constant

  /// image = (image - mean) / deviation, row by row.
  void apply(std::span<float> image, int columns) const;
};

/// Accumulates row statistics image by image, in double and in call order. The deviation is that over N.
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
