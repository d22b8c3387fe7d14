// Resampling of a signal by any ratio: each new sample is a weighted mean of old ones, with a windowed sinc as weights.
// Method: Smith and Gossett, "A flexible sampling-rate conversion method", ICASSP 1984: a fine table of the filter is
// interpolated linearly. Window and length: Kaiser, "Nonrecursive digital filter design", 1974.
#include "recording/resample.hpp"

#include <cmath>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/text.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {

namespace {

// In samples of the lower rate: the filter falls from 1 to 0 between 0.40 and 0.50, -6 dB at 0.45. Kaiser's length for
// 80 dB in that width is (80 - 7.95) / (2.285 * 2 pi * 0.1) = 50.2.
constexpr double cut_off = 0.45;
constexpr int half_length = 26;
constexpr double kaiser_beta = 0.1102 * (80.0 - 8.7);
/// Table entries per sample: linear interpolation errs by (2 pi 0.45 / 512)^2 / 8 = 4e-6, below -100 dB.
constexpr int resolution = 512;
constexpr double max_resampled_samples = 1e8;

/// Returns sin(2 pi x), exact to a few units in 1e-16: sixteenths of a turn from a table, the rest by its series.
double sin_2pi(double x) {
  const double k = std::nearbyint(16.0 * x);
  const SinCos near = sincos_of_turn(static_cast<long long>(k), 16);
  const double rest = sin_small(2.0 * sim::pi * (x - k / 16.0));
  return near.sin * std::sqrt(1.0 - rest * rest) + near.cos * rest;
}

/// Returns the modified Bessel function of order 0: sum of ((x/2)^k / k!)^2.
double bessel_i0(double x) {
  double sum = 1.0, term = 1.0;
  for (int k = 1; term > 1e-17 * sum; ++k) {
    const double factor = 0.5 * x / k;
    term *= factor * factor;
    sum += term;
  }
  return sum;
}

/// Returns the filter at i / resolution samples, i = 0 .. half_length * resolution, and a final zero, so that
/// interpolation at the end needs no special case.
std::vector<double> make_filter() {
  constexpr int last = half_length * resolution;
  std::vector<double> filter(last + 2, 0.0);
  const double scale = 1.0 / bessel_i0(kaiser_beta);
  for (int i = 0; i <= last; ++i) {
    const double t = static_cast<double>(i) / resolution, u = t / half_length;
    const double turns = cut_off * t;
    const double sinc = i == 0 ? 2.0 * cut_off : sin_2pi(turns) / (sim::pi * t);
    filter[static_cast<std::size_t>(i)] = sinc * scale * bessel_i0(kaiser_beta * std::sqrt(1.0 - u * u));
  }
  return filter;
}

/// Returns `count` samples of a signal, the first at `start`, one every `step` samples. at(k) is the signal's sample k,
/// also beyond its ends; k is an integer.
template <class At>
std::vector<double> filtered(const At& at, double start, double step, std::size_t count) {
  static const std::vector<double> filter = make_filter();
  const double shrink = step > 1.0 ? 1.0 / step : 1.0;  // old samples -> samples of the lower rate
  const double reach = half_length / shrink;            // of the filter, in old samples
  std::vector<double> result(count);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double centre = start + static_cast<double>(i) * step;
    double sum = 0.0, weights = 0.0;
    for (double k = std::ceil(centre - reach); k <= centre + reach; k += 1.0) {
      const double position = std::abs(k - centre) * shrink * resolution;
      const auto entry = static_cast<std::size_t>(position);
      const double fraction = position - static_cast<double>(entry);
      const double weight = filter[entry] + fraction * (filter[entry + 1] - filter[entry]);
      sum += weight * at(k);
      weights += weight;
    }
    result[i] = sum / weights;  // keeps constants exact
  }
  return result;
}

auto held(const std::vector<double>& signal) {
  return [&signal, last = static_cast<double>(signal.size() - 1)](double k) {
    return signal[static_cast<std::size_t>(k < 0.0 ? 0.0 : k > last ? last : k)];
  };
}

/// Reflected at both ends repeatedly, the signal repeats every 2 last samples, each time 2 (x(last) - x(0)) higher.
auto reflected(const std::vector<double>& signal) {
  return [&signal, last = static_cast<double>(signal.size() - 1)](double k) {
    if (k >= 0.0 && k <= last) return signal[static_cast<std::size_t>(k)];
    if (last == 0.0) return signal.front();
    const double repeats = std::floor(k / (2.0 * last)), place = k - repeats * 2.0 * last;
    const double value = place <= last ? signal[static_cast<std::size_t>(place)]
                                       : 2.0 * signal.back() - signal[static_cast<std::size_t>(2.0 * last - place)];
    return value + repeats * 2.0 * (signal.back() - signal.front());
  };
}

auto periodic(const std::vector<double>& signal) {
  return [&signal, period = static_cast<double>(signal.size())](double k) {
    return signal[static_cast<std::size_t>(k - period * std::floor(k / period))];
  };
}

void check_rates(double from_hz, double to_hz) {
  const auto usable = [](double rate) { return std::isfinite(rate) && rate > 0.0; };
  if (usable(from_hz) && usable(to_hz)) return;
  throw Error(Code::setting_out_of_range, "resample",
              format("the sample rates %g Hz and %g Hz are not both positive", from_hz, to_hz), "give positive rates");
}

}  // namespace

std::vector<double> resample(const std::vector<double>& signal, double from_hz, double to_hz, Ends ends) {
  check_rates(from_hz, to_hz);
  if (from_hz == to_hz || signal.empty()) return signal;
  // Rounding may move a whole length off its integer.
  const double length = std::floor(static_cast<double>(signal.size()) * (to_hz / from_hz) + 1e-6);
  if (length > max_resampled_samples) {
    throw Error(Code::setting_out_of_range, "resample", "the result would have more than 100 million samples",
                "check the sample rates");
  }
  const auto count = static_cast<std::size_t>(length);
  const double step = from_hz / to_hz;
  return ends == Ends::held ? filtered(held(signal), 0.0, step, count) : filtered(reflected(signal), 0.0, step, count);
}

std::vector<double> resample_cycle(const std::vector<double>& signal, std::size_t count) {
  if (signal.empty()) return {};
  return filtered(periodic(signal), 0.0, static_cast<double>(signal.size()) / static_cast<double>(count), count);
}

std::vector<double> resample(const std::vector<double>& signal, double from_hz, double to_hz, double start_s,
                             std::size_t count) {
  check_rates(from_hz, to_hz);
  if (signal.empty()) return {};
  return filtered(held(signal), start_s * from_hz, from_hz / to_hz, count);
}

}  // namespace decid::recording
