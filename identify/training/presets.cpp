// Ready-made networks: see presets.hpp.
#include "identify/training/presets.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "identify/network/head.hpp"
#include "sim/fft.hpp"

namespace decid {

using dataset::Channel;

namespace {

/// Each cycle has separate planes: more cycles would make up most of the network.
constexpr int max_folded_series = 8, max_series_rows = 2048;

/// Returns the spectrum of the mean of the stimulus' cycles, and of how they differ.
dataset::ImageSettings folded_spectrum(int window, int first_sample, int fold, int rows) {
  return {.window = window,
          .half_spectrum = true,
          .channels = {Channel::asinh_real, Channel::asinh_imaginary, Channel::log_modulus, Channel::log_residual},
          .standardize_rows = true,
          .first_sample = first_sample,
          .fold = fold,
          .rows = rows};
}

// Neighbouring harmonics carry the same information, so convolutions along them come first.
constexpr const char* harmonics_network =
    "conv 48 7x1 stride 2x1 pad 3x0; batchnorm; relu; conv 64 5x1 stride 2x1 pad 2x0; batchnorm; relu; "
    "conv 96 3x1 stride 2x1 pad 1x0; batchnorm; relu; fc 256; batchnorm; relu; fc 7";

std::vector<Preset> make_presets() {
  const dataset::ImageSettings harmonics_image = folded_spectrum(6050, 0, 2, 256);
  return {
      {.name = "best",
       .description = "the spectrum of the cycles' mean and difference, harmonic by harmonic up to 4.2 Hz",
       .architecture = harmonics_network,
       .image = harmonics_image,
       .epochs = 48,
       .learning_rate = 0.05,
       .warmup_epochs = 1},
      {.name = "short",
       .description = "the same for the short protocol, three cycles of 20 s, up to 6.4 Hz",
       .architecture = harmonics_network,
       .image = folded_spectrum(2000, 197, 3, 128),
       .epochs = 24,
       .learning_rate = 0.05,
       .warmup_epochs = 1},
      {.name = "firmware",
       .description = "the network input of best, a network of 53 KB for decid export c",
       .architecture =
           "conv 24 7x1 stride 2x1 pad 3x0; batchnorm; relu; conv 24 5x1 stride 2x1 pad 2x0; batchnorm; relu; "
           "conv 24 5x1 stride 2x1 pad 2x0; batchnorm; relu; conv 24 5x1 stride 2x1 pad 2x0; batchnorm; relu; "
           "conv 22 5x1 stride 2x1 pad 2x0; batchnorm; relu; fc 7",
       .image = harmonics_image,
       .epochs = 160,
       .learning_rate = 0.05,
       .warmup_epochs = 1},
      {.name = "series",
       .description =
           "time series of 10 Hz of the cycles' mean and difference and of the tilt; estimates with intervals; "
           "made for protocols with recording artefacts and bodies of several heights",
       .architecture =
           "conv 48 15x1 stride 2x1 pad 7x0; batchnorm; relu; conv 64 9x1 stride 2x1 pad 4x0; batchnorm; relu; "
           "conv 96 7x1 stride 2x1 pad 3x0; batchnorm; relu; conv 128 7x1 stride 2x1 pad 3x0; batchnorm; relu; "
           "conv 128 5x1 stride 2x1 pad 2x0; batchnorm; relu; statspool; fc 256; batchnorm; relu; fc 72",
       .head = "mixture 2",
       .image = {.window = 6050,
                 .channels = {Channel::sway, Channel::sway_change, Channel::sway_bend, Channel::height, Channel::tilt,
                              Channel::tilt_velocity},
                 .fold = 2,
                 .block = 10},
       .epochs = 128,
       .learning_rate = 0.4,
       .sgd = {.weight_decay = 5e-4},
       .warmup_epochs = 1},
      {.name = "paper",
       .description = "the paper's setting: 64 filters first, raw modulus and phase, 110 x 110",
       .architecture =
           "conv 64 3x3 pad 1x1; batchnorm; relu; maxpool 2x2; conv 64 3x3 pad 1x1; batchnorm; relu; "
           "maxpool 2x2; conv 128 3x3 pad 1x1; batchnorm; relu; maxpool 2x2; conv 128 3x3 pad 1x1; batchnorm; "
           "relu; globalavgpool; fc 7",
       .epochs = 100,
       .learning_rate = 0.01,
       .schedule = "step:30:0.3"},
      {.name = "small",
       .description = "trains in seconds, for first tries",
       .architecture =
           "conv 8 5x5 stride 2x2 pad 2x2; batchnorm; relu; conv 16 3x3 stride 2x2 pad 1x1; batchnorm; relu; "
           "conv 32 3x3 stride 2x2 pad 1x1; batchnorm; relu; globalavgpool; fc 7",
       .image = {.window = 110,
                 .half_spectrum = true,
                 .channels = {Channel::log_modulus, Channel::cos_phase, Channel::sin_phase},
                 .standardize_rows = true},
       .epochs = 10,
       .batch = 32,
       .learning_rate = 0.02},
  };
}

}  // namespace

std::span<const Preset> presets() {
  static const std::vector<Preset> all = make_presets();
  return all;
}

Preset with_head(Preset preset, const std::string& head, std::size_t parameters, const std::string& where) {
  const std::size_t outputs = head_named(head, where).outputs(parameters);
  preset.head = head;
  preset.architecture.resize(preset.architecture.rfind("fc "));
  preset.architecture += "fc " + std::to_string(outputs);
  return preset;
}

dataset::ImageSettings image_for(const Preset& preset, const sim::Protocol& protocol) {
  dataset::ImageSettings image = preset.image;
  if (image.fold == 1) return image;
  // Presets that average cycles are made for 100 Hz.
  const double rate_hz = protocol.experiment.sample_rate_hz;
  const double cycle = protocol.experiment.cycle_s() * rate_hz, lead_in = protocol.experiment.lead_in_s() * rate_hz;
  const auto whole = [](double samples) { return std::abs(samples - std::round(samples)) < 1e-6; };
  const auto transformed = [](int samples) { return sim::max_prime_factor(samples) <= sim::max_fft_prime; };
  const int max_series_cycles = image.block > 0 ? max_folded_series : dataset::max_fold;
  const bool folds = whole(cycle) && whole(lead_in) && cycle <= dataset::max_window &&
                     protocol.experiment.cycles() <= max_series_cycles &&
                     transformed(static_cast<int>(std::lround(cycle)));
  const double window = folds ? cycle : cycle * protocol.experiment.cycles();
  const int fold = folds ? protocol.experiment.cycles() : 1, first_sample = static_cast<int>(std::ceil(lead_in - 1e-6));
  int window_samples = std::min(
      {static_cast<int>(std::floor(window + 1e-6)), dataset::max_window, (protocol.samples() - first_sample) / fold});
  if (image.block > 0) {
    const int same_time = std::max(1, static_cast<int>(std::lround(image.block * rate_hz / 100.0)));
    const int shown = fold > 1 ? window_samples : protocol.samples() - first_sample;
    image.block = std::max(same_time, (shown + max_series_rows - 1) / max_series_rows);
    image.fold = fold;
    image.first_sample = first_sample;
    image.window = fold > 1 ? window_samples : dataset::ImageSettings{}.window;  // not read unless cycles are averaged
    return image;
  }
  while (!transformed(window_samples)) --window_samples;
  if (window_samples == image.window && fold == image.fold && first_sample == image.first_sample) return image;
  image.window = window_samples;
  image.fold = fold;
  image.first_sample = first_sample;
  const double highest_hz = 100.0 * preset.image.rows / preset.image.window;
  image.rows = std::clamp(static_cast<int>(std::lround(highest_hz * window_samples / rate_hz)), 64, 1024);
  image.rows = std::min(image.rows, window_samples / 2 + 1);
  return image;
}

const Preset& preset_named(const std::string& name) {
  std::string names;
  for (const Preset& preset : presets()) {
    if (preset.name == name) return preset;
    names += (names.empty() ? "" : ", ") + preset.name;
  }
  throw Error(Code::setting_unknown, "preset", "'" + name + "' is not a preset", "choose one of " + names);
}

}  // namespace decid
