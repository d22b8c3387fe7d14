// Images: every channel against a direct Fourier sum, the mirrored half, row statistics, settings as JSON.
#include "dataset/image/image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "base/math/random.hpp"
#include "sim/protocol/protocol.hpp"
#include "sim/protocol/stimulus.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::dataset;
using namespace decid::test;

namespace {

/// Rounding from double to float, and a little for the double's own error.
constexpr double rounding = 0x1.01p-24;

const std::vector<Channel> all_channels{Channel::modulus,   Channel::log_modulus, Channel::phase,    Channel::cos_phase,
                                        Channel::sin_phase, Channel::real,        Channel::imaginary};

std::vector<float> noise(int samples, std::uint64_t item = 0) {
  const Random random(5, sim::streams::sensor_noise, item);
  std::vector<float> signal(static_cast<std::size_t>(samples));
  for (std::size_t k = 0; k < signal.size(); ++k) signal[k] = static_cast<float>(0.01 * random.normal(k));
  return signal;
}

std::vector<float> image_of(const ImageMaker& maker, std::span<const float> sway) {
  std::vector<float> image(static_cast<std::size_t>(maker.shape().size()), -99.0f);
  maker.make(sway, image);
  return image;
}

std::complex<double> direct_bin(std::span<const float> window, int k) {
  const auto n = static_cast<double>(window.size());
  std::complex<double> sum = 0.0;
  for (std::size_t i = 0; i < window.size(); ++i) {
    sum +=
        static_cast<double>(window[i]) * std::polar(1.0, -2.0 * sim::pi * std::fmod(k * static_cast<double>(i), n) / n);
  }
  return sum;
}

/// Values of an image by channel, row and column.
struct View {
  const std::vector<float>& image;
  ImageShape shape;
  double operator()(std::size_t channel, int row, int column) const {
    return image[(channel * static_cast<std::size_t>(shape.rows) + static_cast<std::size_t>(row)) *
                     static_cast<std::size_t>(shape.columns) +
                 static_cast<std::size_t>(column)];
  }
};

void check_against_direct_sum(int window, bool half) {
  const int columns = 3, samples = columns * window + 1;
  const std::vector<float> sway = noise(samples);
  const ImageMaker maker({window, half, all_channels, false}, samples);
  const ImageShape shape = maker.shape();
  CHECK(shape.channels == 7);
  CHECK(shape.rows == (half ? window / 2 + 1 : window));
  CHECK(shape.columns == columns);
  const std::vector<float> image = image_of(maker, sway);
  const View value{image, shape};
  const double scale = 0.01 * std::sqrt(window), tolerance = 2e-7 * scale;  // float's rounding of values of that size
  for (int column = 0; column < columns; ++column) {
    const auto part =
        std::span(sway).subspan(static_cast<std::size_t>(column * window), static_cast<std::size_t>(window));
    for (int row = 0; row < shape.rows; ++row) {
      std::complex<double> z = direct_bin(part, row);
      if (row == 0 || 2 * row == window) z = z.real();
      CAPTURE(window);
      CAPTURE(row);
      CAPTURE(column);
      REQUIRE(std::abs(z) > 1e-3 * scale);  // so that the phase is well defined
      CHECK(std::abs(value(0, row, column) - std::abs(z)) < 4 * tolerance);
      CHECK(near(value(1, row, column), std::log(std::abs(z)), rounding));
      CHECK(std::abs(std::polar(1.0, value(2, row, column)) - z / std::abs(z)) < 1e-6);
      CHECK(value(2, row, column) > -sim::pi);
      CHECK(value(2, row, column) <= static_cast<double>(static_cast<float>(sim::pi)));
      CHECK(std::abs(value(3, row, column) - z.real() / std::abs(z)) < 1e-6);
      CHECK(std::abs(value(4, row, column) - z.imag() / std::abs(z)) < 1e-6);
      CHECK(std::abs(value(5, row, column) - z.real()) < 4 * tolerance);
      CHECK(std::abs(value(6, row, column) - z.imag()) < 4 * tolerance);
    }
  }
}

}  // namespace

TEST_CASE("every channel shows the bins of a direct Fourier sum") {
  for (const int window : {2, 3, 10, 11, 55, 110, 128}) {
    check_against_direct_sum(window, false);
    check_against_direct_sum(window, true);
  }
}

TEST_CASE("the paper's image is 2 x 110 x 110") {
  const ImageShape shape = ImageMaker({}, 12100).shape();
  CHECK(shape.channels == 2);
  CHECK(shape.rows == 110);
  CHECK(shape.columns == 110);
}

TEST_CASE("the upper half mirrors the lower") {
  for (const int window : {8, 9}) {
    const int samples = 4 * window;
    const ImageMaker maker({window, false, all_channels, false}, samples);
    const std::vector<float> image = image_of(maker, noise(samples));
    const View value{image, maker.shape()};
    for (int column = 0; column < 4; ++column) {
      for (int k = 1; k < window; ++k) {
        for (const std::size_t even : {0u, 1u, 3u, 5u})
          CHECK(value(even, k, column) == value(even, window - k, column));
        if (2 * k == window) continue;  // real: its own conjugate
        for (const std::size_t odd : {2u, 4u, 6u}) CHECK(value(odd, k, column) == -value(odd, window - k, column));
      }
    }
  }
}

TEST_CASE("fewer rows are the lowest of all; a window may be a whole cycle") {
  const std::vector<float> sway = noise(12'100);
  ImageSettings settings{.window = 6050, .half_spectrum = true, .channels = all_channels, .fold = 2};
  const ImageMaker whole(settings, 12'100);
  settings.rows = 256;
  const ImageMaker lowest(settings, 12'100);
  CHECK(whole.shape().rows == 3026);
  CHECK(lowest.shape().rows == 256);
  CHECK(lowest.shape().columns == 1);
  const std::vector<float> all = image_of(whole, sway), some = image_of(lowest, sway);
  for (std::size_t channel = 0; channel < all_channels.size(); ++channel) {
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(channel * 3026);
    CHECK(std::equal(first, first + 256, some.begin() + static_cast<std::ptrdiff_t>(channel * 256)));
  }
}

TEST_CASE("silence: modulus 0, its logarithm at the floor, phase 0") {
  const ImageMaker maker({10, false, all_channels, false}, 10);
  const std::vector<float> image = image_of(maker, std::vector<float>(10, 0.0f));
  const View value{image, maker.shape()};
  for (int row = 0; row < 10; ++row) {
    CHECK(value(0, row, 0) == 0.0);
    CHECK(value(1, row, 0) == static_cast<double>(static_cast<float>(std::log(1e-6))));
    CHECK(value(2, row, 0) == 0.0);
    CHECK(value(3, row, 0) == 1.0);
    CHECK(value(4, row, 0) == 0.0);
  }
}

TEST_CASE("the phase of negative real bins is +pi, in both halves") {
  std::vector<float> impulse(8, 0.0f);
  impulse[0] = -1.0f;  // every bin is -1
  const ImageMaker maker({8, false, {Channel::phase}, false}, 8);
  for (const float phase : image_of(maker, impulse)) CHECK(phase == static_cast<float>(sim::pi));
}

TEST_CASE("samples that fill no window are left out") {
  const std::vector<float> sway = noise(25);
  const ImageMaker longer({10, false, {Channel::real}, false}, 25), exact({10, false, {Channel::real}, false}, 20);
  CHECK(longer.shape().columns == 2);
  CHECK(image_of(longer, sway) == image_of(exact, std::span(sway).first(20)));
}

TEST_CASE("image sizes and settings out of bounds are refused") {
  check_error([] { ImageMaker({}, 109); }, Code::setting_out_of_range, "110");
  check_error([] { ImageSettings{.window = 1}.validate(); }, Code::setting_out_of_range, "1");
  check_error([] { ImageSettings{.window = 131073}.validate(); }, Code::setting_out_of_range, "131073");
  check_error([] { ImageSettings{.rows = 5}.validate(); }, Code::setting_out_of_range, "half_spectrum");
  check_error([] { ImageSettings{.half_spectrum = true, .rows = 57}.validate(); }, Code::setting_out_of_range,
              "57 rows");
  check_error([] { ImageSettings{.half_spectrum = true, .rows = -1}.validate(); }, Code::setting_out_of_range,
              "-1 rows");
  check_error([] { ImageMaker({.window = 0}, 100); }, Code::setting_out_of_range, "0");
  check_error([] { ImageSettings{.channels = {}}.validate(); }, Code::setting_out_of_range, "0 channels");
  check_error([] { ImageSettings{.channels = std::vector<Channel>(17)}.validate(); }, Code::setting_out_of_range,
              "17 channels");
  const ImageMaker maker({.window = 10}, 20);
  std::vector<float> sway(20), image(40);
  check_error([&] { maker.make(std::span<const float>(sway).first(19), image); }, Code::size_mismatch, "19 samples");
  check_error([&] { maker.make(sway, std::span(image).first(39)); }, Code::size_mismatch, "39 values");
  const std::array<Sway, 2> two{Sway(sway), Sway(std::span<const float>(sway).first(18))};
  std::vector<float> images(80);
  check_error([&] { maker.make_all(two, images); }, Code::size_mismatch, "18 samples");
  check_error([&] { maker.make_all(std::span(two).first(1), images); }, Code::size_mismatch, "80 values");
}

TEST_CASE("image settings come back from JSON") {
  for (const ImageSettings& settings : {ImageSettings{}, ImageSettings{64, true, all_channels, true},
                                        ImageSettings{2, false, {Channel::real}, false}}) {
    CHECK(image_settings_from_json(to_json(settings), "settings") == settings);
  }
  CHECK(image_settings_from_json("{}", "settings") == ImageSettings{});
  const auto parsing = [](const char* text) { return [text] { image_settings_from_json(text, "m.json"); }; };
  check_error(parsing("{\"window\": }"), Code::setting_malformed, "line 1, column 12");
  check_error(parsing(R"({"windows": 110})"), Code::setting_unknown, "'windows'");
  check_error(parsing(R"({"window": "110"})"), Code::setting_malformed, "'window'");
  check_error(parsing(R"({"window": 1})"), Code::setting_out_of_range, "1");
  check_error(parsing(R"({"half_spectrum": 1})"), Code::setting_malformed, "'half_spectrum'");
  check_error(parsing(R"({"channels": "phase"})"), Code::setting_malformed, "'channels'");
  check_error(parsing(R"({"channels": []})"), Code::setting_out_of_range, "0 channels");
  check_error(parsing(R"({"channels": ["phase", "colour"]})"), Code::setting_unknown, "'colour'");
  check_error(parsing(R"({"standardize_rows": null})"), Code::setting_malformed, "'standardize_rows'");
  const std::string deep = "{\"channels\": " + std::string(100'000, '[') + std::string(100'000, ']') + "}";
  check_error([&] { image_settings_from_json(deep, "m.safetensors"); }, Code::setting_malformed, "32");
}

TEST_CASE("row statistics are those of two passes over all images") {
  const int samples = 200;
  const ImageMaker maker({10, true, {Channel::log_modulus, Channel::phase, Channel::imaginary}, true}, samples);
  const ImageShape shape = maker.shape();
  RowStatistics statistics(shape);
  std::vector<std::vector<float>> images;
  for (std::uint64_t item = 0; item < 7; ++item) {
    images.push_back(image_of(maker, noise(samples, item)));
    statistics.add(images.back());
  }
  const RowScaling scaling = statistics.finish();
  const auto rows = static_cast<std::size_t>(shape.channels * shape.rows);
  const auto columns = static_cast<std::size_t>(shape.columns);
  REQUIRE(scaling.mean.size() == rows);
  const double count = 7.0 * shape.columns;
  for (std::size_t row = 0; row < rows; ++row) {
    double mean = 0.0, squares = 0.0;
    for (const auto& image : images) {
      for (std::size_t k = 0; k < columns; ++k) mean += image[row * columns + k] / count;
    }
    for (const auto& image : images) {
      for (std::size_t k = 0; k < columns; ++k) squares += std::pow(image[row * columns + k] - mean, 2) / count;
    }
    CHECK(near(scaling.mean[row], mean, rounding));
    if (squares == 0.0) {
      CHECK(scaling.stddev[row] == 1.0f);  // the imaginary part of bin 0
    } else {
      CHECK(near(scaling.stddev[row], std::sqrt(squares), rounding));
    }
  }
  std::vector<float> scaled = images[3];
  scaling.apply(scaled, shape.columns);
  for (std::size_t i = 0; i < scaled.size(); ++i) {
    const std::size_t row = i / columns;
    CHECK(scaled[i] == (images[3][i] - scaling.mean[row]) / scaling.stddev[row]);
  }
}

TEST_CASE("a constant row has deviation 1 even where its mean is rounded") {
  RowStatistics statistics({1, 1, 7});
  const std::vector<float> image(7, 0.1f);
  for (int i = 0; i < 10; ++i) statistics.add(image);
  CHECK(statistics.finish().mean[0] == 0.1f);
  CHECK(statistics.finish().stddev[0] == 1.0f);
}

TEST_CASE("row statistics refuse images of another shape") {
  RowStatistics statistics({1, 2, 3});
  check_error([&] { statistics.finish(); }, Code::trials_missing);
  const std::vector<float> five(5), six{1, 2, 3, 4, 5, 6};
  check_error([&] { statistics.add(five); }, Code::size_mismatch, "5 values");
  statistics.add(six);
  std::vector<float> copy = five;
  check_error([&] { statistics.finish().apply(copy, 3); }, Code::size_mismatch, "5 values");
}

TEST_CASE("folded cycles: the mean, and how the cycles differ from it") {
  const int window = 10, columns = 4, lead = 7;
  const std::vector<Channel> channels{Channel::real,       Channel::imaginary,       Channel::log_residual,
                                      Channel::asinh_real, Channel::asinh_imaginary, Channel::log_modulus};
  for (const int fold : {1, 2, 3}) {
    CAPTURE(fold);
    const int samples = lead + fold * columns * window + 5;
    const std::vector<float> sway = noise(samples, 3);
    const ImageMaker maker({window, false, channels, false, lead, fold}, samples);
    CHECK(maker.shape().columns == columns);
    const std::vector<float> image = image_of(maker, sway);
    const View value{image, maker.shape()};
    for (int column = 0; column < columns; ++column)
      for (int row = 0; row < window; ++row) {
        std::vector<std::complex<double>> bins;
        std::complex<double> mean = 0;
        for (int cycle = 0; cycle < fold; ++cycle) {
          const int first = lead + (cycle * columns + column) * window;
          bins.push_back(direct_bin(std::span(sway).subspan(static_cast<std::size_t>(first), window), row));
          mean += bins.back() / static_cast<double>(fold);
        }
        double squares = 0;
        for (const auto& bin : bins) squares += std::norm(bin - mean) / fold;
        CHECK(std::abs(value(0, row, column) - mean.real()) < 1e-8);
        CHECK(std::abs(value(1, row, column) - mean.imag()) < 1e-8);
        if (fold > 1)
          CHECK(near(value(2, row, column), 0.5 * std::log(squares), rounding));
        else
          CHECK(value(2, row, column) == static_cast<double>(static_cast<float>(std::log(min_modulus_rad))));
        const auto check_asinh = [](double shown, double part) {
          // Near 0, what the sum's own roundings leave, in knees.
          const double exact = std::asinh(part / asinh_knee_rad);
          CHECK(within(shown, exact, rounding * std::abs(exact) + 1e-12));
        };
        check_asinh(value(3, row, column), mean.real());
        check_asinh(value(4, row, column), mean.imag());
        CHECK(near(value(5, row, column), std::log(std::abs(mean)), rounding));
      }
  }
  check_error([&] { ImageMaker({window, false, channels, false, 95, 1}, 100); }, Code::setting_out_of_range);
  check_error([&] { ImageMaker({window, false, channels, false, 0, 11}, 100); }, Code::setting_out_of_range, "11");
  check_error(
      [&] {
        ImageMaker({window, false, channels, false, -1, 1}, 100);
      },
      Code::setting_out_of_range, "first_sample");
  check_error([&] { ImageMaker({window, false, channels, false, 0, 0}, 100); }, Code::setting_out_of_range);
}

TEST_CASE("every instruction set draws the same bits") {
  std::vector<Channel> channels = all_channels;
  channels.insert(channels.end(), {Channel::asinh_real, Channel::asinh_imaginary, Channel::log_residual});
  // The paper's windows, a fold, an odd window, a last block of columns that is not full, values over 60 decades.
  std::vector<float> sway = noise(12'100);
  for (std::size_t k = 0; k < sway.size(); k += 3) sway[k] *= std::pow(10.0F, static_cast<float>(k % 60) - 30.0F);
  for (std::size_t k = 500; k < 900; ++k) sway[k] = 0.0F;
  for (const auto& [window, fold, half] : {std::tuple{110, 1, false}, {110, 2, true}, {57, 3, false}, {64, 1, true}}) {
    const ImageMaker maker({.window = window, .half_spectrum = half, .channels = channels, .fold = fold}, 12'100);
    std::vector<float> plain(static_cast<std::size_t>(maker.shape().size()), -99.0F);
    maker.make(sway, plain, Isa::reference);
    for (const Isa isa : available_isas()) {
      CAPTURE(name(isa));
      std::vector<float> image(plain.size(), 99.0F);
      maker.make(sway, image, isa);
      CHECK(image == plain);
    }
  }
}

TEST_CASE("images of several trials are those of each alone, with every instruction set") {
  constexpr int samples = 360;
  std::vector<std::vector<float>> sways;
  for (int i = 0; i < 19; ++i) sways.push_back(noise(samples, static_cast<std::uint64_t>(i)));
  const std::vector<Sway> all(sways.begin(), sways.end());
  // Windows of which a trial has 1, 2, 3 or 36: eight, four, two or one trial share the lanes.
  for (const auto& [settings_of_it, together] : {std::pair{ImageSettings{.window = 180, .fold = 2}, 8},
                                                 {{.window = 360}, 8},
                                                 {{.window = 180}, 4},
                                                 {{.window = 120}, 2},
                                                 {{.window = 10}, 1}}) {
    ImageSettings settings = settings_of_it;
    CAPTURE(settings.window);
    settings.half_spectrum = true;
    settings.rows = 5;
    settings.channels = {Channel::log_modulus, Channel::phase, Channel::log_residual};
    const ImageMaker maker(settings, samples);
    CHECK(maker.trials_together() == together);
    const auto values = static_cast<std::size_t>(maker.shape().size());
    std::vector<float> alone(all.size() * values);
    for (std::size_t i = 0; i < all.size(); ++i) maker.make(all[i], std::span(alone).subspan(i * values, values));
    for (const Isa isa : available_isas()) {
      CAPTURE(name(isa));
      for (const std::size_t count : {1U, 2U, 7U, 19U}) {
        std::vector<float> images(count * values, -99.0F);
        maker.make_all(std::span(all).first(count), images, isa);
        CHECK(std::equal(images.begin(), images.end(), alone.begin()));
      }
    }
  }
}

TEST_CASE("series: means of blocks, their changes and the changes of these, the tilt") {
  const sim::Protocol protocol = sim::default_protocol();
  const int samples = protocol.samples(), block = 10, lead = 7;
  const ImageSettings settings{.channels = {Channel::tilt_velocity, Channel::sway_bend, Channel::sway, Channel::tilt,
                                            Channel::sway_change, Channel::torque, Channel::height},
                               .first_sample = lead,
                               .block = block};
  const ImageMaker maker(settings, protocol.experiment);
  CHECK(maker.shape().channels == 7);
  CHECK(maker.shape().rows == (samples - lead) / block);
  CHECK(maker.shape().columns == 1);
  const std::vector<float> sway = noise(samples);
  const std::vector<float> image = image_of(maker, sway);
  const View view{image, maker.shape()};
  std::vector<float> of_taller(image.size());
  maker.make(Sway(sway, 1.2), of_taller);
  const auto mean = [&](int row) {
    double sum = 0.0;
    for (int i = 0; i < block; ++i) sum += double{sway[static_cast<std::size_t>(lead + row * block + i)]};
    return sum / block;
  };
  const sim::Stimulus stimulus = sim::make_stimulus(protocol.experiment);
  const auto tilt = [&](int row) {
    double sum = 0.0;
    for (int i = 0; i < block; ++i)
      sum += stimulus.tilt_rad[static_cast<std::size_t>(lead + row * block + i) *
                               static_cast<std::size_t>(10 / stimulus.interval_steps)];
    return sum / block;
  };
  CHECK(view(0, 0, 0) == 0.0);
  CHECK(view(1, 0, 0) == 0.0);
  CHECK(view(1, 1, 0) == 0.0);
  CHECK(view(4, 0, 0) == 0.0);
  for (int row = 2; row < maker.shape().rows; row += 11) {
    const double here = mean(row), before = mean(row - 1), earlier = mean(row - 2);
    CHECK(near(view(2, row, 0), std::asinh(here / 5e-3), 2 * rounding));
    CHECK(within(view(4, row, 0), std::asinh((here - before) / 1e-3), 1e-6));
    CHECK(within(view(1, row, 0), std::asinh((here - 2 * before + earlier) / 5e-4), 1e-6));
    CHECK(within(view(3, row, 0), tilt(row) / 0.01, 1e-6));
    CHECK(within(view(0, row, 0), (tilt(row) - tilt(row - 1)) / 0.1 / 0.01, 1e-5));
    const double lean_s2 = protocol.experiment.body.inertia_kgm2 / protocol.experiment.body.mgh();
    const double bend = (here - 2 * before + earlier) / 0.01;
    CHECK(within(view(5, row, 0), std::asinh((before - lean_s2 * bend) / 5e-3), 1e-6));
    CHECK(view(6, row, 0) == 0.0);
    const View taller{of_taller, maker.shape()};
    CHECK(within(taller(5, row, 0), std::asinh((before - 1.2 * lean_s2 * bend) / 5e-3), 1e-6));
    CHECK(within(taller(6, row, 0), 2.0, 1e-6));
    CHECK(taller(2, row, 0) == view(2, row, 0));
  }
  CHECK(view(5, 1, 0) == 0.0);
  for (const Isa isa : available_isas()) {
    std::vector<float> again(image.size());
    maker.make(sway, again, isa);
    CHECK(again == image);
  }
  CHECK(image_settings_from_json(to_json(settings), "test") == settings);
}

TEST_CASE("series: cycles as their mean and contrasts") {
  constexpr int cycle = 200, block = 10, lead = 5, samples = lead + 3 * cycle + 7;
  const ImageSettings settings{.window = cycle,
                               .channels = {Channel::sway, Channel::sway_change},
                               .first_sample = lead,
                               .fold = 3,
                               .block = block};
  const ImageMaker maker(settings, samples);
  CHECK(maker.shape().channels == 6);
  CHECK(maker.shape().rows == cycle / block);
  const std::vector<float> sway = noise(samples);
  const std::vector<float> image = image_of(maker, sway);
  const View view{image, maker.shape()};
  const auto mean = [&](int of, int row) {
    double sum = 0.0;
    for (int i = 0; i < block; ++i) sum += double{sway[static_cast<std::size_t>(lead + of * cycle + row * block + i)]};
    return sum / block;
  };
  const auto parts = [&](int row) {
    const double a = mean(0, row), b = mean(1, row), c = mean(2, row);
    return std::array{(a + b + c) / 3.0, (b - a) * std::sqrt(0.5), (c - (a + b) / 2.0) * std::sqrt(2.0 / 3.0)};
  };
  for (int row = 1; row < maker.shape().rows; ++row) {
    for (std::size_t part = 0; part < 3; ++part) {
      const double here = parts(row)[part], before = parts(row - 1)[part];
      CHECK(within(view(part, row, 0), std::asinh(here / 5e-3), 1e-6));
      CHECK(within(view(3 + part, row, 0), std::asinh((here - before) / 1e-3), 1e-6));
    }
  }
  CHECK(image_settings_from_json(to_json(settings), "test") == settings);
}

TEST_CASE("series: errors") {
  const ImageSettings sway{.channels = {Channel::sway}, .block = 10}, tilt{.channels = {Channel::tilt}, .block = 10};
  check_error([&] { ImageMaker(tilt, 100); }, Code::setting_missing, "'tilt'");
  check_error([] { ImageMaker({.channels = {Channel::torque}, .block = 10}, 100); }, Code::setting_missing, "'torque'");
  check_error([&] { ImageMaker(sway, 9); }, Code::setting_out_of_range, "10");
  check_error([] { ImageMaker({.channels = {Channel::sway}}, 1000); }, Code::setting_conflict, "'sway'");
  check_error([] { ImageMaker({.channels = {Channel::phase}, .block = 10}, 1000); }, Code::setting_conflict, "'phase'");
  check_error([] { ImageMaker({.window = 501, .channels = {Channel::sway}, .fold = 2, .block = 10}, 1000); },
              Code::setting_out_of_range, "2");
  check_error([] { ImageMaker({.window = 50, .channels = {Channel::sway}, .block = 10}, 1000); },
              Code::setting_conflict);
  check_error([] { ImageMaker({.channels = {Channel::sway}, .block = -1}, 1000); }, Code::setting_out_of_range, "-1");
}
