// Low-passes of recordings: see low_pass.hpp. The spectrum's mean power in a band of n independent bins is
// gamma distributed about that of the model, so its deviance is 2 n (p / m - log(p / m) - 1); nonnegative sums of known
// spectra are fitted to it by multiplicative updates: Fevotte, Bertin, Durrieu, Neural Computation 21, 2009.
#include "recording/low_pass.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "base/math/math.hpp"
#include "recording/quality/detail/block_means.hpp"
#include "recording/quality/detail/hann_spectrum.hpp"
#include "sim/fft.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::recording {
namespace {

constexpr double lowest_hz = 2.0, highest_hz = 60.0, min_highest_hz = 11.9, max_rate_fraction = 0.48;
constexpr double thinned_hz = 400.0;
constexpr int all_bands = 48, min_bands = 24;
constexpr double min_bins = 2.0, bins_per_independent = 1.5;  // of a band, under Hann's window
constexpr int max_order = 4, cutoffs = 14, finer_cutoffs = 13, finer_candidates = 3;
constexpr double lowest_cutoff_hz = 1.8, min_cutoff_hz = 2.2, max_cutoff_fraction = 0.3, finer_factor = 0.15;
constexpr int lower_cutoffs = 7;
constexpr double lower_factor = 1.292;  // 1.8 Hz over its seventh power are 0.3 Hz
constexpr int coarse_updates = 25, finer_updates = 100;
/// A filter has to lower the deviance by this. Unfiltered sway in white and slow noise gives up to 100.
constexpr double min_gain_of_deviance = 200.0;
constexpr double min_deviance_of_band = 0.3, max_deviance_of_band = 3.0;  // 1 for the true model and noise
/// The updates leave this part of the deviance behind steep filters. Unfiltered sway has more.
constexpr double max_deviance_left = 0.02;
constexpr double as_likely_deviance = 6.0;      // a likelihood ratio of 20, with a deviance of 1 a band
constexpr double cutoff_of_average = 0.442946;  // times the rate over the samples: sin(pi x) / (pi x) = sqrt(1/2)
constexpr double min_effect = 0.01, min_delay_s = 0.005;
constexpr double min_gain = 0.1, max_gain_range = 0.08, min_undone_gain = 0.05, much_gain = 0.7;

double tan_of(double hz, double rate_hz) {
  constexpr long long parts = 1LL << 40;
  const auto [sin, cos] =
      sincos_of_turn(static_cast<long long>(0.5 * hz / rate_hz * static_cast<double>(parts)), parts);
  return sin / cos;
}

/// The mean power of the spectrum in bands whose edges have one ratio.
struct Bands {
  std::vector<double> hz, power, count;  ///< count: of independent bins
};
Bands bands_of(const PowerSpectrum& spectrum, double max_hz) {
  Bands all;
  const double ratio = decid::log(max_hz / lowest_hz) / all_bands;
  const auto bin_at = [&](int edge) {
    return static_cast<std::size_t>(std::ceil(lowest_hz * decid::exp(ratio * edge) / spectrum.step_hz));
  };
  for (int band = 0; band < all_bands; ++band) {
    const std::size_t first = bin_at(band), end = std::min(bin_at(band + 1), spectrum.power.size());
    if (static_cast<double>(end) < static_cast<double>(first) + min_bins) continue;
    double sum = 0.0;
    for (std::size_t k = first; k < end; ++k) sum += spectrum.power[k];
    const auto count = static_cast<double>(end - first);
    all.hz.push_back(0.5 * static_cast<double>(first + end - 1) * spectrum.step_hz);
    all.power.push_back(sum / count);
    all.count.push_back(count / bins_per_independent);
  }
  return all;
}

/// Spectra whose nonnegative sum is fitted: one value per band each.
using Spectra = std::vector<std::vector<double>>;

/// Returns the least deviance of a nonnegative sum of the spectra from the power in bands.
double deviance_of(const Spectra& spectra, const Bands& bands, int updates) {
  const std::size_t count = bands.hz.size();
  std::vector<double> size, model(count);
  for (const std::vector<double>& spectrum : spectra) {
    double min_ratio = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < count; ++k) min_ratio = std::min(min_ratio, bands.power[k] / spectrum[k]);
    size.push_back(min_ratio / static_cast<double>(spectra.size()));
  }
  const auto sum = [&] {
    std::ranges::fill(model, 0.0);
    for (std::size_t i = 0; i < spectra.size(); ++i)
      for (std::size_t k = 0; k < count; ++k) model[k] += size[i] * spectra[i][k];
  };
  std::vector<double> weight(count), pull(count);
  for (int update = 0; update < updates; ++update) {
    sum();
    for (std::size_t k = 0; k < count; ++k) {
      weight[k] = bands.count[k] / model[k];
      pull[k] = weight[k] * (bands.power[k] / model[k]);
    }
    for (std::size_t i = 0; i < spectra.size(); ++i) {
      double up = 0.0, down = 0.0;
      for (std::size_t k = 0; k < count; ++k) {
        up += spectra[i][k] * pull[k];
        down += spectra[i][k] * weight[k];
      }
      size[i] *= up / down;
    }
  }
  sum();
  double deviance = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    const double ratio = bands.power[k] / model[k];
    deviance += 2.0 * bands.count[k] * (ratio - decid::log(ratio) - 1.0);
  }
  return deviance;
}

/// Returns the spectra of sway and noise in front of a filter: powers 0, -2, -4, -6 of the frequency.
Spectra unfiltered(const Bands& bands) {
  Spectra spectra(4);
  for (const double hz : bands.hz) {
    const double square = lowest_hz * lowest_hz / (hz * hz);
    spectra[0].push_back(1.0);
    spectra[1].push_back(square);
    spectra[2].push_back(square * square);
    spectra[3].push_back(square * square * square);
  }
  return spectra;
}

/// Returns the spectra behind a filter, and that of rounding.
Spectra filtered(Spectra spectra, const LowPass& filter, const Bands& bands) {
  for (std::size_t k = 0; k < bands.hz.size(); ++k) {
    const double gain = filter.gain_at(bands.hz[k]);
    for (std::vector<double>& spectrum : spectra) spectrum[k] *= gain * gain;
  }
  spectra.emplace_back(bands.hz.size(), 1.0);
  return spectra;
}

struct Candidate {
  LowPass filter;
  double deviance = std::numeric_limits<double>::infinity();
};

/// Compares filters with a spectrum, and keeps all of them.
struct Comparison {
  const Spectra& spectra;
  const Bands& bands;
  std::vector<Candidate> all = {};

  const Candidate& add(LowPass filter, double cutoff_hz, int updates) {
    filter.cutoff_hz = cutoff_hz;
    return all.emplace_back(Candidate{filter, deviance_of(filtered(spectra, filter, bands), bands, updates)});
  }
};

/// Adds the filters of each order and number of passes, each with the same number of cutoffs from the lowest to the
/// highest that noise shows: half a step between them is within refined(). Returns the likeliest of each, the likeliest
/// of all first.
std::vector<Candidate> likeliest_of_each(double rate_hz, Comparison& comparison) {
  std::vector<Candidate> likeliest;
  const double width = decid::log(std::min(max_cutoff_fraction * rate_hz, highest_hz) / lowest_cutoff_hz);
  for (int order = 1; order <= max_order; ++order)
    for (const bool both_ways : {false, true}) {
      Candidate& best = likeliest.emplace_back();
      for (int i = 0; i < cutoffs; ++i) {
        const Candidate& next =
            comparison.add(LowPass{order, both_ways, 0.0, rate_hz},
                           lowest_cutoff_hz * decid::exp(width * i / (cutoffs - 1)), coarse_updates);
        if (next.deviance < best.deviance) best = next;
      }
    }
  std::ranges::stable_sort(likeliest, {}, &Candidate::deviance);
  return likeliest;
}

/// Adds cutoffs near those of the likeliest filters. Returns the likeliest of all.
Candidate refined(std::span<const Candidate> likeliest, Comparison& comparison) {
  Candidate best = likeliest.front();
  for (const Candidate& middle : likeliest)
    for (int i = 0; i < finer_cutoffs; ++i) {
      const double factor = decid::exp(finer_factor * (2.0 * i / (finer_cutoffs - 1) - 1.0));
      const Candidate& next = comparison.add(middle.filter, middle.filter.cutoff_hz * factor, finer_updates);
      if (next.deviance < best.deviance) best = next;
    }
  return best;
}

/// Adds lower cutoffs where the lowest one is as likely: below the bands only a filter's slope shows, so a sum of
/// slopes in front of it may hide its cutoff.
void add_lower_cutoffs(double max_likely_deviance, Comparison& comparison) {
  for (std::size_t kind = 0; kind < std::size_t{2} * max_order; ++kind) {
    Candidate last = comparison.all[kind * cutoffs];
    for (int i = 0; i < lower_cutoffs && last.deviance <= max_likely_deviance; ++i)
      last = comparison.add(last.filter, last.filter.cutoff_hz / lower_factor, coarse_updates);
  }
}

}  // namespace

LowPass moving_average(int samples, double rate_hz) {
  LowPass filter;
  filter.cutoff_hz = cutoff_of_average * rate_hz / samples;
  filter.rate_hz = rate_hz;
  filter.averaged = samples;
  filter.gain_low = filter.gain_high = filter.gain_at(low_pass_hz);
  return filter;
}

double LowPass::gain_at(double hz) const {
  if (averaged > 0) {
    const double turns = 0.5 * hz / rate_hz, one = sincos_of_turns(turns).sin;
    return one == 0.0 ? 1.0 : std::abs(sincos_of_turns(averaged * turns).sin / (averaged * one));
  }
  const double ratio = tan_of(hz, rate_hz) / tan_of(cutoff_hz, rate_hz);
  double power = 1.0;
  for (int i = 0; i < order; ++i) power *= ratio * ratio;
  return both_ways ? 1.0 / (1.0 + power) : 1.0 / std::sqrt(1.0 + power);
}

// Minus the slope of the phase at 0 Hz: the sum over the poles of cos(angle) / |pole|.
double LowPass::delay_s() const {
  if (both_ways) return 0.0;
  if (averaged > 0) return 0.5 * (averaged - 1) / rate_hz;
  return 1.0 / (2.0 * sim::pi * cutoff_hz * sincos_of_turn(1, 4LL * order).sin);
}

std::optional<LowPass> find_low_pass(std::span<const double> sway_rad, double rate_hz) {
  const auto block = std::max<std::size_t>(1, static_cast<std::size_t>(rate_hz / thinned_hz));
  const double thin_hz = rate_hz / static_cast<double>(block);
  const double max_hz = std::min(highest_hz, max_rate_fraction * thin_hz);
  if (max_hz < min_highest_hz || sway_rad.size() < block) return {};
  const Bands bands = bands_of(hann_spectrum(block_means(sway_rad, block), thin_hz), max_hz);
  if (bands.hz.size() < min_bands || *std::ranges::min_element(bands.power) <= 0.0) return {};
  const Spectra spectra = unfiltered(bands);
  const double without = deviance_of(spectra, bands, coarse_updates);
  if (without < min_gain_of_deviance) return {};
  Comparison comparison{spectra, bands};
  const std::vector<Candidate> likeliest = likeliest_of_each(rate_hz, comparison);
  const double max_deviance = max_deviance_of_band * static_cast<double>(bands.hz.size());
  const double max_steep_deviance = std::max(max_deviance, max_deviance_left * without);
  // Only a slope shows, and it explains the spectrum badly, or better than that of noise: sway without noise.
  const auto is_noiseless = [&](const Candidate& of) {
    return of.filter.cutoff_hz < min_cutoff_hz &&
           (of.deviance > max_steep_deviance ||
            of.deviance < min_deviance_of_band * static_cast<double>(bands.hz.size()));
  };
  if (is_noiseless(likeliest.front())) return {};
  const Candidate best = refined(std::span(likeliest).first(finer_candidates), comparison);
  if (is_noiseless(best) || best.deviance > max_steep_deviance || without - best.deviance < min_gain_of_deviance)
    return {};
  const double of_band = best.deviance / static_cast<double>(bands.hz.size());
  const double max_likely_deviance = best.deviance + as_likely_deviance * std::max(1.0, of_band);
  add_lower_cutoffs(max_likely_deviance, comparison);
  LowPass found = best.filter;
  found.gain_low = found.gain_high = found.gain_at(low_pass_hz);
  for (const Candidate& other : comparison.all) {
    if (other.deviance > max_likely_deviance) continue;
    found.gain_low = std::min(found.gain_low, other.filter.gain_at(low_pass_hz));
    found.gain_high = std::max(found.gain_high, other.filter.gain_at(low_pass_hz));
  }
  if (best.deviance > max_deviance) {  // too unlike this filter to undo it
    if (found.gain_low >= much_gain) return {};
    found.gain_high = 1.0;
  }
  if (found.gain_low > 1.0 - min_effect && found.delay_s() < min_delay_s) return {};
  return found;
}

bool can_undo(const LowPass& filter) {
  return filter.gain_low >= min_gain && filter.gain_high - filter.gain_low <= max_gain_range;
}

bool removes_much(const LowPass& filter) {
  return !can_undo(filter) || filter.gain_at(low_pass_hz) < much_gain;
}

std::vector<float> undo(const LowPass& filter, std::span<const float> sway_rad, double rate_hz) {
  const std::size_t samples = sway_rad.size();
  if (samples == 0) return {};
  const int length = sim::smooth_length(static_cast<int>(2 * samples));
  // The mirror image, and the first sample held, continue the signal at both ends.
  std::vector<double> values(static_cast<std::size_t>(length), double{sway_rad[0]});
  for (std::size_t i = 0; i < samples; ++i) values[i] = values[2 * samples - 1 - i] = double{sway_rad[i]};
  const sim::RealFft fft(length);
  std::vector<sim::Complex> bins(static_cast<std::size_t>(fft.bins())),
      work(static_cast<std::size_t>(fft.work_length()));
  fft.forward(values, bins, work);
  for (std::size_t k = 0; k < bins.size(); ++k) {
    const double hz = std::min(static_cast<double>(k) * rate_hz / length, max_rate_fraction * filter.rate_hz);
    bins[k] /= std::max(min_undone_gain, filter.gain_at(hz));
  }
  fft.inverse(bins, values, work);
  return {values.begin(), values.begin() + static_cast<std::ptrdiff_t>(samples)};
}

std::vector<SampleRange> gaps_after_undo(const LowPass& filter, std::span<const SampleRange> gaps, double rate_hz,
                                         std::size_t samples) {
  const auto margin = static_cast<std::size_t>(std::ceil(rate_hz / filter.cutoff_hz));
  std::vector<SampleRange> wider;
  for (const SampleRange& gap : gaps)
    wider.push_back({gap.first - std::min(gap.first, margin), std::min(gap.end + margin, samples)});
  return joined_ranges(std::move(wider));
}

}  // namespace decid::recording
