// Network inputs from trials: the FFT of each window, drawn as the settings say, eight windows at a time
// (kernels/generic.hpp). A real signal's spectrum is its own mirror image, so only the lower half is computed: bin
// (window - k) is the conjugate of bin k. Row statistics: exact mean and squares of each input in two passes, joined by
// the update of Chan, Golub and LeVeque, "Updating formulae and a pairwise algorithm for computing sample variances",
// 1979.
#include "dataset/image/image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "base/per_thread.hpp"
#include "base/text.hpp"
#include "dataset/image/image_object.hpp"
#include "dataset/image/kernels/image.hpp"

namespace decid::dataset {

namespace {

static_assert(image_lanes == sim::fft_lanes);

constexpr std::array<std::pair<Channel, const char*>, 17> channel_names{{
    {Channel::modulus, "modulus"},
    {Channel::log_modulus, "log_modulus"},
    {Channel::phase, "phase"},
    {Channel::cos_phase, "cos_phase"},
    {Channel::sin_phase, "sin_phase"},
    {Channel::real, "real"},
    {Channel::imaginary, "imaginary"},
    {Channel::asinh_real, "asinh_real"},
    {Channel::asinh_imaginary, "asinh_imaginary"},
    {Channel::log_residual, "log_residual"},
    {Channel::sway, "sway"},
    {Channel::sway_change, "sway_change"},
    {Channel::sway_bend, "sway_bend"},
    {Channel::torque, "torque"},
    {Channel::height, "height"},
    {Channel::tilt, "tilt"},
    {Channel::tilt_velocity, "tilt_velocity"},
}};

std::string list_of_channels() {
  return joined(channel_names, ", ", [](const auto& named) { return named.second; });
}

/// Throws Error unless the trials have equal lengths, and there is space for all images.
void check_sizes(std::span<const Sway> sways, std::size_t samples, std::span<const float> images,
                 std::size_t image_size) {
  for (const Sway& sway : sways)
    if (sway.rad.size() != samples)
      throw Error(Code::size_mismatch, "image",
                  "a trial has " + std::to_string(sway.rad.size()) + " samples instead of " + std::to_string(samples),
                  "give trials of equal length");
  if (images.size() != sways.size() * image_size)
    throw Error(Code::size_mismatch, "image",
                "got space for " + std::to_string(images.size()) + " values for " + std::to_string(sways.size()) +
                    " images of " + std::to_string(image_size),
                "give space for all of them");
}

}  // namespace

const char* name(Channel channel) {
  for (const auto& [known, text] : channel_names) {
    if (known == channel) return text;
  }
  throw Error(Code::setting_unknown, "image", "channel " + std::to_string(static_cast<int>(channel)) + " is unknown",
              "use one of " + list_of_channels());
}

Channel channel_from_name(const std::string& name) {
  for (const auto& [channel, known] : channel_names) {
    if (name == known) return channel;
  }
  throw Error(Code::setting_unknown, "image", "channel '" + name + "' is unknown", "use one of " + list_of_channels());
}

void ImageSettings::validate() const {
  if (window < 2 || window > max_window) {
    throw Error(Code::setting_out_of_range, "image", "the window has " + std::to_string(window) + " samples",
                "give 2 to " + std::to_string(max_window));
  }
  if (rows < 0 || rows > window / 2 + 1 || (rows > 0 && !half_spectrum)) {
    throw Error(Code::setting_out_of_range, "image",
                "a window of " + std::to_string(window) + " samples has " + std::to_string(rows) + " rows",
                "with half_spectrum give at most window / 2 + 1; else, or for all rows, give 0");
  }
  if (channels.empty() || channels.size() > 16) {
    throw Error(Code::setting_out_of_range, "image", "has " + std::to_string(channels.size()) + " channels",
                "give 1 to 16");
  }
  if (block < 0 || block > max_window)
    throw Error(Code::setting_out_of_range, "image", "the block has " + std::to_string(block) + " samples",
                "give at most " + std::to_string(max_window) + ", or 0 for spectra");
  for (const Channel channel : channels)
    if (is_of_series(channel) != (block > 0))
      throw Error(
          Code::setting_conflict, "image",
          std::string("channel '") + name(channel) + "' does not belong to " + (block > 0 ? "time series" : "spectra"),
          block > 0 ? "use sway, sway_change, sway_bend, torque, height, tilt or tilt_velocity"
                    : "set block to use channels of time series");
  if (block > 0 && (half_spectrum || rows != 0 || (fold == 1 && window != ImageSettings{}.window)))
    throw Error(Code::setting_conflict, "image",
                "time series do not go with half_spectrum, rows, or a window without cycle averaging",
                "leave these out; they apply to spectra");
  if (first_sample < 0 || first_sample > 1'000'000'000) {
    throw Error(Code::setting_out_of_range, "image", "first_sample is " + std::to_string(first_sample),
                "give 0 or more");
  }
  if (fold < 1 || fold > max_fold)
    throw Error(Code::setting_out_of_range, "image", "fold is " + std::to_string(fold),
                "give 1 to " + std::to_string(max_fold) + " cycles");
}

Json to_json_object(const ImageSettings& settings) {
  std::vector<std::string> channels;
  for (const Channel channel : settings.channels) channels.emplace_back(name(channel));
  if (settings.block > 0) {
    Json json{{"block", settings.block},
              {"channels", channels},
              {"standardize_rows", settings.standardize_rows},
              {"first_sample", settings.first_sample}};
    if (settings.fold > 1) json.update({{"fold", settings.fold}, {"window", settings.window}});
    return json;
  }
  return {{"window", settings.window},
          {"half_spectrum", settings.half_spectrum},
          {"rows", settings.rows},
          {"channels", channels},
          {"standardize_rows", settings.standardize_rows},
          {"first_sample", settings.first_sample},
          {"fold", settings.fold}};
}

std::string to_json(const ImageSettings& settings) {
  return print_json(to_json_object(settings));
}

ImageSettings image_settings_from_json(const std::string& text, const std::string& where) {
  const Json json = parse_json(text, where);
  ImageSettings settings;
  JsonObject object(json, where);
  object.read("window", settings.window);
  object.read("half_spectrum", settings.half_spectrum);
  object.read("rows", settings.rows);
  std::vector<std::string> channels;
  const bool has_channels = json.contains("channels");
  object.read("channels", channels);
  object.read("standardize_rows", settings.standardize_rows);
  object.read("first_sample", settings.first_sample);
  object.read("fold", settings.fold);
  object.read("block", settings.block);
  object.finish();
  try {
    if (has_channels) {
      settings.channels.clear();
      for (const std::string& channel : channels) settings.channels.push_back(channel_from_name(channel));
    }
    settings.validate();
  } catch (const Error& error) {
    throw Error(error.code(), where, error.where() + ": " + error.problem(), error.remedy());
  }
  return settings;
}

ImageMaker::ImageMaker(ImageSettings settings, int samples) : ImageMaker(std::move(settings), samples, nullptr) {}

ImageMaker::ImageMaker(ImageSettings settings, const sim::Experiment& experiment)
    : ImageMaker(std::move(settings), experiment.samples(), &experiment) {}

ImageMaker::ImageMaker(ImageSettings settings, int samples, const sim::Experiment* experiment)
    : settings_((settings.validate(), std::move(settings))),
      samples_(samples),
      fft_(settings_.window),
      rows_(settings_.block > 0       ? cycle_samples() / settings_.block
            : settings_.rows > 0      ? settings_.rows
            : settings_.half_spectrum ? fft_.bins()
                                      : settings_.window) {
  if (rows_ < 1 || shape().columns < 1) {
    const std::string part = settings_.block > 0 ? "block" : "window";
    throw Error(Code::setting_out_of_range, "image",
                "a " + part + " of " + std::to_string(settings_.block > 0 ? settings_.block : settings_.window) +
                    " samples, times a fold of " + std::to_string(settings_.fold) + ", does not fit into a trial of " +
                    std::to_string(samples) + " samples from sample " + std::to_string(settings_.first_sample),
                "choose a shorter " + part + " or a longer trial");
  }
  if (experiment != nullptr) {
    show_tilt(*experiment);
    bend_over_lean_s2_ = experiment->body.inertia_kgm2 / experiment->body.mgh();
    return;
  }
  for (const Channel channel : settings_.channels)
    if (channel == Channel::tilt || channel == Channel::tilt_velocity || channel == Channel::torque)
      throw Error(Code::setting_missing, "image",
                  std::string("channel '") + name(channel) + "' needs a tilt and a body",
                  "give the experiment of the trials");
}

int ImageMaker::cycle_samples() const noexcept {
  const int samples = std::max(samples_ - settings_.first_sample, 0);
  if (settings_.fold == 1) return samples;
  return samples / settings_.fold < settings_.window ? 0 : settings_.window;
}

ImageShape ImageMaker::shape() const noexcept {
  if (settings_.block > 0) {
    const auto of_sway = static_cast<int>(std::ranges::count_if(settings_.channels, is_of_sway));
    return {static_cast<int>(settings_.channels.size()) + (settings_.fold - 1) * of_sway, rows_, 1};
  }
  const int samples = std::max(samples_ - settings_.first_sample, 0);
  return {static_cast<int>(settings_.channels.size()), rows_, samples / settings_.window / settings_.fold};
}

// A single window has the same bits, without seven idle lanes, in an eighth of the memory.
void ImageMaker::transform_alone(std::span<const float> window, std::span<double> spectrum) const {
  struct Scratch {
    std::vector<double> signal;
    std::vector<sim::Complex> bins, complex_work;
  };
  auto& [signal, bins, complex_work] = per_thread<Scratch>();
  signal.assign(window.begin(), window.end());
  bins.resize(static_cast<std::size_t>(fft_.bins()));
  complex_work.resize(static_cast<std::size_t>(fft_.work_length()));
  fft_.forward(signal, bins, complex_work);
  for (std::size_t k = 0; k < bins.size(); ++k) {
    spectrum[2 * k * image_lanes] = bins[k].real();
    spectrum[(2 * k + 1) * image_lanes] = bins[k].imag();
  }
}

int ImageMaker::trials_together() const noexcept {
  if (settings_.block > 0) return 1;
  return std::max(1, image_lanes / shape().columns);
}

void ImageMaker::make(const Sway& sway, std::span<float> image, Isa isa) const {
  make_all({&sway, 1}, image, isa);
}

void ImageMaker::make_all(std::span<const Sway> sways, std::span<float> images, Isa isa) const {
  const ImageShape size = shape();
  const auto image_size = static_cast<std::size_t>(size.size());
  check_sizes(sways, static_cast<std::size_t>(samples_), images, image_size);
  if (settings_.block > 0) {
    for (std::size_t i = 0; i < sways.size(); ++i)
      make_series(sways[i], images.subspan(i * image_size, image_size), isa);
    return;
  }
  const ImageKernels& kernels = image_kernels(isa);
  const auto window = static_cast<std::size_t>(settings_.window), bins = static_cast<std::size_t>(fft_.bins());
  const auto plane_size = static_cast<std::size_t>(size.rows) * static_cast<std::size_t>(size.columns);
  const auto fold = static_cast<std::size_t>(settings_.fold), columns = static_cast<std::size_t>(size.columns);
  const int shown = std::min(fft_.bins(), rows_);
  constexpr std::size_t lanes = image_lanes;
  // Kept between calls: 2.5 MB if the window is a whole cycle.
  struct Scratch {
    std::vector<double> signal, spectra, work, mean, residual;
  };
  auto& [signal, spectra, work, mean, residual] = per_thread<Scratch>();
  const auto grow = [](std::vector<double>& buffer, std::size_t count) {
    buffer.resize(std::max(buffer.size(), count));
  };
  grow(signal, window * lanes);
  grow(spectra, 2 * bins * lanes * fold);
  grow(work, 2 * static_cast<std::size_t>(fft_.work_length()) * lanes);
  grow(mean, 2 * bins * lanes);
  grow(residual, bins * lanes);
  const std::size_t all = sways.size() * columns;  // columns of all images, one after another
  for (std::size_t first = 0; first < all; first += lanes) {
    const std::size_t here = std::min(lanes, all - first);
    for (std::size_t cycle = 0; cycle < fold; ++cycle) {
      const std::span<double> spectrum = std::span(spectra).subspan(cycle * 2 * bins * lanes, 2 * bins * lanes);
      std::array<const float*, lanes> windows{};
      for (std::size_t lane = 0; lane < here; ++lane) {
        const std::size_t trial = (first + lane) / columns, column = (first + lane) % columns;
        windows[lane] = sways[trial].rad.data() + static_cast<std::size_t>(settings_.first_sample) +
                        (cycle * columns + column) * window;
      }
      if (here == 1) {
        transform_alone({windows[0], window}, spectrum);
        continue;
      }
      kernels.load_windows(windows.data(), settings_.window, static_cast<int>(here), signal.data());
      fft_.forward_lanes(std::span(signal).first(window * lanes), spectrum,
                         std::span(work).first(2 * static_cast<std::size_t>(fft_.work_length()) * lanes), isa);
    }
    kernels.average_cycles(settings_.fold, fft_.bins(), shown, spectra.data(), mean.data(), residual.data());
    std::array<float*, lanes> planes{};
    for (std::size_t lane = 0; lane < here; ++lane)
      planes[lane] = images.data() + (first + lane) / columns * image_size + (first + lane) % columns;
    for (const Channel channel : settings_.channels) {
      kernels.draw({channel, shown, settings_.window, size.rows, size.columns, static_cast<int>(here), mean.data(),
                    residual.data(), planes.data()});
      for (std::size_t lane = 0; lane < here; ++lane) planes[lane] += plane_size;
    }
  }
}

void RowScaling::apply(std::span<float> image, int columns) const {
  if (columns < 1 || stddev.size() != mean.size() || image.size() != mean.size() * static_cast<std::size_t>(columns)) {
    throw Error(Code::size_mismatch, "image",
                "an image has " + std::to_string(image.size()) + " values, and the row statistics are for " +
                    std::to_string(mean.size()) + " rows of " + std::to_string(columns),
                "use the statistics made with these image settings");
  }
  auto value = image.begin();
  for (std::size_t row = 0; row < mean.size(); ++row) {
    for (int column = 0; column < columns; ++column, ++value) *value = (*value - mean[row]) / stddev[row];
  }
}

RowStatistics::RowStatistics(ImageShape shape)
    : shape_(shape), mean_(static_cast<std::size_t>(shape.channels * shape.rows), 0.0), squares_(mean_.size(), 0.0) {}

void RowStatistics::add(std::span<const float> image) {
  if (image.size() != static_cast<std::size_t>(shape_.size())) {
    throw Error(Code::size_mismatch, "image",
                "an image has " + std::to_string(image.size()) + " values instead of " + std::to_string(shape_.size()),

                "add images of equal shape");
  }
  const auto columns = static_cast<std::size_t>(shape_.columns);
  const double count = shape_.columns, before = static_cast<double>(images_) * count, after = before + count;
  for (std::size_t row = 0; row < mean_.size(); ++row) {
    const std::span<const float> values = image.subspan(row * columns, columns);
    double sum = 0.0, squares = 0.0;
    for (const float value : values) sum += value;
    const double row_mean = sum / count;
    for (const float value : values) squares += (value - row_mean) * (value - row_mean);
    const double change = row_mean - mean_[row];
    mean_[row] += change * (count / after);
    squares_[row] += squares + change * change * (before * (count / after));
  }
  ++images_;
}

RowScaling RowStatistics::finish() const {
  if (images_ == 0)
    throw Error(Code::trials_missing, "image", "row statistics have no images", "add the training set's images first");
  const double count = static_cast<double>(images_) * shape_.columns;
  RowScaling scaling;
  for (std::size_t row = 0; row < mean_.size(); ++row) {
    const double stddev = std::sqrt(squares_[row] / count);
    // A standard deviation below float's resolution is rounding, not signal.
    const bool constant = stddev <= 1e-7 * std::abs(mean_[row]);
    scaling.mean.push_back(static_cast<float>(mean_[row]));
    scaling.stddev.push_back(constant ? 1.0f : static_cast<float>(stddev));
  }
  return scaling;
}

}  // namespace decid::dataset
