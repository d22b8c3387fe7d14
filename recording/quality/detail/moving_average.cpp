// Finds moving averages in a sway: see moving_average.hpp. A mean over T has the response sin(pi f T) / (pi f T).
#include "recording/quality/detail/moving_average.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/math/math.hpp"
#include "recording/quality/detail/block_means.hpp"
#include "recording/quality/detail/hann_spectrum.hpp"

namespace decid::recording {

namespace {

/// Below 4 Hz a body's sway falls so steeply that the power at a multiple differs from the power around it anyway.
constexpr double lowest_hz = 4.0, highest_hz = 60.0, max_average_s = 2.0, min_step_s = 1e-3;
/// Half the width of a stretch of the spectrum, in distances between zeros.
constexpr double half_width = 0.1;
/// The sway is analysed in parts, most of which must agree: a rectangular pulse, as of an occluded marker, has such a
/// spectrum too.
constexpr std::size_t spectrum_parts = 3;
/// The longest length searched for, as a fraction of a part: each stretch of the spectrum then holds six bins.
constexpr double max_part_fraction = 1.0 / 30.0;
/// White noise gives 0, a moving average -4.3: the mean of log(sin(pi x)^2) over |x| < 0.1.
constexpr double min_fall = -1.5;

/// Sums of the logarithms of (power times frequency squared) over the bins of a sway's spectrum. The frequency factor
/// compensates the decay of a moving average's response.
class LogSpectrum {
 public:
  explicit LogSpectrum(const PowerSpectrum& spectrum) : step_hz_(spectrum.step_hz) {
    sums_.push_back(0.0);
    for (std::size_t k = 0; k < spectrum.power.size(); ++k) {
      const double bin = static_cast<double>(k);
      sums_.push_back(sums_.back() + log(std::max(spectrum.power[k] * bin * bin, 1e-300)));
    }
  }

  /// Returns the mean over the frequencies up to `half_hz` from `at_hz`.
  double mean(double at_hz, double half_hz) const {
    const auto first = static_cast<std::size_t>(std::ceil((at_hz - half_hz) / step_hz_));
    const auto last = std::min(static_cast<std::size_t>(std::floor((at_hz + half_hz) / step_hz_)), sums_.size() - 2);
    return (sums_[last + 1] - sums_[first]) / static_cast<double>(last + 1 - first);
  }

 private:
  double step_hz_;
  std::vector<double> sums_;
};

/// Returns the depth of the zeros of a moving average over `length_s`: the mean logarithm of the power at the zeros
/// minus the lower mean halfway to the neighbouring zeros. Returns 0 for fewer than two zeros. Skips zeros of the
/// tilt's own spectrum, at the multiples of 1 / held_s.
double fall_at_zeros(const LogSpectrum& spectrum, double length_s, double max_hz, double held_s) {
  const double apart_hz = 1.0 / length_s, half_hz = half_width * apart_hz;
  double fall = 0.0;
  int zeros = 0;
  // The spectrum of a filter that falls steeply does not rise after a zero.
  for (double k = std::ceil(lowest_hz * length_s); (k + 0.5) * apart_hz <= max_hz; k += 1.0) {
    const double of_tilt = k * apart_hz * held_s, nearest = std::floor(of_tilt + 0.5);
    if (nearest > 0.0 && std::abs(of_tilt - nearest) < half_hz * held_s) continue;
    ++zeros;
    fall += spectrum.mean(k * apart_hz, half_hz) -
            std::min(spectrum.mean((k - 0.5) * apart_hz, half_hz), spectrum.mean((k + 0.5) * apart_hz, half_hz));
  }
  return zeros < 2 ? 0.0 : fall / zeros;
}

}  // namespace

double moving_average_s(std::span<const double> sway_rad, double rate_hz, double held_s) {
  constexpr double thinned_hz = 400.0, min_bins = 300.0;
  const std::size_t block = std::max<std::size_t>(1, static_cast<std::size_t>(rate_hz / thinned_hz));
  const double thin_hz = rate_hz / static_cast<double>(block);
  const double max_hz = std::min(highest_hz, 0.5 * thin_hz);
  const std::vector<double> sway = block_means(sway_rad, block);
  const std::size_t samples = sway.size() / spectrum_parts;
  const double part_s = static_cast<double>(samples) / thin_hz;
  if (part_s * max_hz < min_bins) return 0.0;
  std::vector<LogSpectrum> spectra;
  for (std::size_t part = 0; part < spectrum_parts; ++part) {
    const auto begin = sway.begin() + static_cast<std::ptrdiff_t>(part * samples);
    spectra.emplace_back(
        hann_spectrum(std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(samples)), thin_hz));
  }
  double found_s = 0.0, lowest_fall = min_fall;
  const double step_s = std::max(1.0 / rate_hz, min_step_s);
  for (double length_s = 2.0 * step_s; length_s <= std::min(max_average_s, max_part_fraction * part_s);
       length_s += step_s) {
    std::array<double, spectrum_parts> falls{};
    for (std::size_t part = 0; part < spectrum_parts; ++part)
      falls[part] = fall_at_zeros(spectra[part], length_s, max_hz, held_s);
    std::ranges::sort(falls);
    const double fall = falls[spectrum_parts / 2];
    if (!(fall < lowest_fall)) continue;
    lowest_fall = fall;
    found_s = length_s;
  }
  return found_s;
}

}  // namespace decid::recording
