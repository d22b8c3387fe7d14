// Finds faults in the samples of sway: see quality.hpp.
#include "recording/quality/detail/quality.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "base/math/statistics.hpp"
#include "base/setting.hpp"
#include "recording/quality/detail/block_means.hpp"
#include "recording/quality/detail/gaps.hpp"
#include "recording/quality/detail/moving_average.hpp"
#include "recording/table/columns.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {

namespace {

constexpr double min_sway_s = 2.0;
constexpr std::size_t min_samples = 20;
constexpr double stretches_fraction = 0.02;
constexpr double step_deg = 0.02, coarse_deg = 0.2;
constexpr double spike_deg = 0.05, spike_medians = 20.0, spike_steps = 3.0;
/// A sensor below them loses the response to the platform; trial.cpp refuses recordings below the first.
constexpr double slowest_held_hz = 5.0, slow_held_hz = 10.0;
constexpr double smooth_deg = 0.0003, noise_rate_hz = 50.0, trained_average_s = 0.25;

std::string seconds(std::size_t samples, double rate_hz, double begin_s = 0.0) {
  return three_digits(begin_s + static_cast<double>(samples) / rate_hz) + " s";
}

/// The part of a warning that describes stretches.
struct StretchesText {
  std::string text;  ///< empty: there are none
  bool is_caution = false;
};
StretchesText describe(const std::vector<SampleRange>& stretches, std::size_t samples, double rate_hz, double begin_s) {
  if (stretches.empty()) return {};
  std::size_t all = 0, longest = 0;
  for (const SampleRange& stretch : stretches) {
    all += stretch.size();
    longest = std::max(longest, stretch.size());
  }
  const double fraction = static_cast<double>(all) / static_cast<double>(samples);
  return {std::to_string(stretches.size()) + (stretches.size() == 1 ? " stretch" : " stretches") + ", the longest " +
              seconds(longest, rate_hz) + ", the first from " + seconds(stretches.front().first, rate_hz, begin_s) +
              " on, " + three_digits(100.0 * fraction) + "% of the recording: ",
          fraction >= stretches_fraction};
}

/// Returns the step of a coarse sensor in rad; 0 if there is none.
double find_step(std::span<const double> sway) {
  const auto [lowest, highest] = std::ranges::minmax(sway);
  double step = highest - lowest;
  const double same = 1e-9 * step;
  // Most sensors are fine enough that two consecutive samples show it, and sorting is unnecessary. There are fewer
  // values between the two samples than samples. So two of the values are farther apart than `same` and nearer to each
  // other than the two samples.
  const double some = 2.0 * static_cast<double>(sway.size()) * same, fine = 0.9 * step_deg * sim::rad_per_deg;
  const auto is_fine = [&](double a, double b) { return std::abs(a - b) > some && std::abs(a - b) < fine; };
  if (std::ranges::adjacent_find(sway, is_fine) != sway.end()) return 0.0;
  std::vector<double> values(sway.begin(), sway.end());
  std::ranges::sort(values);
  for (std::size_t k = 1; k < values.size(); ++k)
    if (const double apart = values[k] - values[k - 1]; apart > same) step = std::min(step, apart);
  if (step / sim::rad_per_deg < step_deg * (1.0 - 1e-6)) return 0.0;
  const bool multiples = std::ranges::all_of(values, [&](double value) {
    const double steps = (value - values.front()) / step;
    return std::abs(steps - std::round(steps)) < 0.01;
  });
  return multiples ? step : 0.0;
}

/// Returns `spikes`, or nothing. `step`: the step of a coarse sensor, whose values flicker.
Warnings look_for_spikes(std::span<const double> sway, double rate_hz, double step, double begin_s) {
  // off[k]: the distance of sample k + 1 from the middle of its neighbours.
  std::vector<double> off(sway.size() - 2);
  for (std::size_t k = 0; k < off.size(); ++k) off[k] = sway[k + 1] - 0.5 * (sway[k] + sway[k + 2]);
  std::vector<double> sizes(off.size());
  std::ranges::transform(off, sizes.begin(), [](double value) { return std::abs(value); });
  const double min_distance =
      std::max({spike_deg * sim::rad_per_deg, spike_medians * median(std::move(sizes)), spike_steps * step});
  std::size_t spikes = 0, first = 0;
  double largest = 0.0;
  const auto found = [&](std::size_t sample, double size) {
    if (spikes++ == 0) first = sample;
    largest = std::max(largest, std::abs(size));
  };
  // The outermost sample's distance from the line through the next two is twice that of the second sample, off[0], from
  // the middle; the third sample, off[1], lies on it. If the second sample is wrong, the third is half as far off.
  const auto is_outermost = [&](double second, double third) {
    return 2.0 * std::abs(second) > min_distance && 4.0 * std::abs(third) < std::abs(second);
  };
  const auto is_second = [&](double second, double third) {
    return std::abs(second) > min_distance && std::abs(second) > 1.5 * std::abs(third) &&
           4.0 * std::abs(third) >= std::abs(second);
  };
  const std::size_t last = off.size() - 1;
  if (is_outermost(off[0], off[1])) found(0, 2.0 * off[0]);
  if (is_second(off[0], off[1])) found(1, off[0]);
  for (std::size_t k = 1; k < last; ++k) {
    // A jump to another level is equally far off on both sides; a single sample is twice as far off as its neighbours.
    const double beside = std::max(std::abs(off[k - 1]), std::abs(off[k + 1]));
    if (std::abs(off[k]) > min_distance && std::abs(off[k]) > 1.5 * beside) found(k + 1, off[k]);
  }
  if (is_second(off[last], off[last - 1])) found(last + 1, off[last]);
  if (is_outermost(off[last], off[last - 1])) found(last + 2, 2.0 * off[last]);
  if (spikes == 0) return {};
  return {{Severity::caution, "spikes",
           (spikes == 1 && first == 0 ? "the first sample is"
            : spikes == 1             ? "a single sample is"
                                      : std::to_string(spikes) + " single samples are") +
               std::string(" off by ") + (spikes == 1 ? "" : "up to ") + three_digits(largest / sim::rad_per_deg) +
               " degrees" + (first == 0 && spikes == 1 ? "" : ", the first at " + seconds(first, rate_hz, begin_s)) +
               ": leave them empty and give " + setting("fill_gaps") + ", or cut the recording"}};
}

constexpr std::size_t side_samples = 8;  ///< on each side of a jump
constexpr double finest_hz = 100.0;
constexpr double jump_deg = 0.1, jump_medians = 12.0, jump_steps = 3.0;
constexpr double still_s = 0.1;
constexpr std::size_t still_samples = 5;

/// Returns means of `block` samples, after replacing each sample by the median of itself and its two nearest
/// neighbours. Single wrong samples leave no trace.
std::vector<double> smoothed(std::span<const double> sway, std::size_t block) {
  std::vector<double> medians(sway.begin(), sway.end());
  const auto clamp = [&](std::size_t k, std::size_t a, std::size_t b) {
    const auto [low, high] = std::minmax(sway[a], sway[b]);
    medians[k] = std::clamp(sway[k], low, high);
  };
  for (std::size_t k = 1; k + 1 < sway.size(); ++k) clamp(k, k - 1, k + 1);
  if (sway.size() >= 3) {
    const std::size_t last = sway.size() - 1;
    clamp(0, 1, 2);
    clamp(last, last - 2, last - 1);
  }
  return block_means(medians, block);
}

/// Returns the weights of eight samples with which their fitted line is extrapolated by half a step.
std::array<double, side_samples> weights() {
  std::array<double, side_samples> all{};
  const double n = side_samples, middle = 0.5 * (n - 1.0), squares = n * (n * n - 1.0) / 12.0;
  for (std::size_t i = 0; i < side_samples; ++i)
    all[i] = 1.0 / n + (static_cast<double>(i) - middle) * (n - 0.5 - middle) / squares;
  return all;
}

/// Returns for each k the line through the samples from k on minus the line through those before, at k; 0 near the
/// ends.
std::vector<double> jumps_of(const std::vector<double>& sway) {
  const std::array<double, side_samples> weight = weights();
  std::vector<double> jumps(sway.size(), 0.0);
  for (std::size_t k = side_samples; k + side_samples <= sway.size(); ++k)
    for (std::size_t i = 0; i < side_samples; ++i)
      jumps[k] += weight[i] * (sway[k + side_samples - 1 - i] - sway[k - side_samples + i]);
  return jumps;
}

/// Sets jumps to 0 around a frozen sensor that continues at another level, unless it froze at a level of its own.
void take_out_frozen(std::span<const double> sway, double rate_hz, std::size_t block, double min_jump,
                     std::vector<double>& jumps) {
  for (std::size_t begin = 0, end = 1; end <= sway.size(); ++end) {
    if (end < sway.size() && sway[end] == sway[begin]) continue;
    const std::size_t run = end - begin;
    const bool is_frozen = run >= still_samples && static_cast<double>(run) >= still_s * rate_hz && begin > 0 &&
                           std::abs(sway[begin] - sway[begin - 1]) <= min_jump;
    const std::size_t first = begin / block > side_samples ? begin / block - side_samples : 0;
    for (std::size_t i = first; is_frozen && i < std::min(end / block + side_samples, jumps.size()); ++i)
      jumps[i] = 0.0;
    begin = end;
  }
}

/// Returns the length of the longest run of two zeros or more behind another sample; 0 without one.
std::size_t longest_run_of_zeros(std::span<const double> sway) {
  std::size_t longest = 0, run = 0;
  bool has_begun = false;
  for (const double value : sway) {
    has_begun = has_begun || value != 0.0;
    run = has_begun && value == 0.0 ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  return longest > 1 ? longest : 0;
}

/// Returns the remedy for jumps.
std::string remedy_for_jumps(std::span<const double> sway, double rate_hz) {
  const std::size_t zeros = longest_run_of_zeros(sway);
  if (zeros == 0) return "leave wrong stretches empty and give " + setting("fill_gaps") + ", or cut the recording";
  const double gap_s = std::ceil(1e4 * static_cast<double>(zeros) / rate_hz - 1e-6) / 1e4;
  return "if its zeros stand for missing samples (occluded markers), give " + setting("missing") + " 0 and " +
         setting("fill_gaps") + " " + six_digits(gap_s) + "; else leave wrong stretches empty, or cut the recording";
}

/// Returns `jumps`, or nothing. Lines are fitted by least squares to eight samples at about 100 Hz. Ignores single
/// wrong samples, and the end of a stretch in which the sensor froze. `step_rad`: the step of a coarse sensor, or 0.
Warnings look_for_jumps(std::span<const double> sway_rad, double rate_hz, double step_rad, double begin_s) {
  const std::size_t block = std::max<std::size_t>(1, static_cast<std::size_t>(rate_hz / finest_hz));
  std::vector<double> jumps = jumps_of(smoothed(sway_rad, block));
  if (jumps.size() < 4 * side_samples) return {};
  std::vector<double> sizes(jumps.size());
  std::ranges::transform(jumps, sizes.begin(), [](double jump) { return std::abs(jump); });
  const double min_jump =
      std::max({jump_deg * sim::rad_per_deg, jump_medians * median(std::move(sizes)), jump_steps * step_rad});
  take_out_frozen(sway_rad, rate_hz, block, min_jump, jumps);
  std::size_t count = 0, first = 0;
  double largest = 0.0;
  for (std::size_t k = 0; k < jumps.size(); ++k) {
    if (std::abs(jumps[k]) <= min_jump) continue;
    // The largest jump nearby counts.
    std::size_t at = k, end = k;
    for (; end < std::min(jumps.size(), at + side_samples + 1); ++end)
      if (std::abs(jumps[end]) > std::abs(jumps[at])) at = end;
    if (count++ == 0) first = at;
    largest = std::max(largest, std::abs(jumps[at]));
    k = end - 1;
  }
  if (count == 0) return {};
  return {{Severity::caution, "jumps",
           "the sway jumps in " + std::to_string(count) + (count == 1 ? " place" : " places") + ", by up to " +
               three_digits(largest / sim::rad_per_deg) + " degrees, the first after " +
               three_digits(begin_s + static_cast<double>(first * block) / rate_hz) +
               " s, which a body cannot do: " + remedy_for_jumps(sway_rad, rate_hz)}};
}

/// Returns the standard deviation of the noise between 12 and 25 Hz, in degrees.
double measurement_noise_deg(std::span<const double> sway, double rate_hz) {
  const auto block = static_cast<std::size_t>(rate_hz / noise_rate_hz);
  const std::vector<double> mean = block_means(sway, block);
  // White noise of variance 1 has fourth differences of variance 1 + 16 + 36 + 16 + 1. Unlike their mean square, their
  // median is the sensor's in spite of single wrong samples.
  std::vector<double> fourth;
  fourth.reserve(mean.size());
  for (std::size_t i = 4; i < mean.size(); ++i)
    fourth.push_back(std::abs(mean[i] - 4.0 * mean[i - 1] + 6.0 * mean[i - 2] - 4.0 * mean[i - 3] + mean[i - 4]));
  return stddev_by_median(std::move(fourth)) / std::sqrt(70.0) / sim::rad_per_deg;
}

/// Describes a low-pass.
std::string describe(const LowPass& filter) {
  const std::string at = "at " + three_digits(low_pass_hz) + " Hz it keeps ";
  if (!can_undo(filter))
    return "a low-pass smoothed the sway, and the spectrum leaves open which: " + at +
           three_digits(100.0 * filter.gain_low) + " to " + three_digits(100.0 * filter.gain_high) +
           "% of the sway, and it may delay it; give unfiltered recordings";
  std::string text = "a low-pass of about " + three_digits(filter.cutoff_hz) +
                     " Hz smoothed the sway (like Butterworth's of order " + std::to_string(filter.order) +
                     (filter.both_ways ? ", forwards and backwards" : "") + "): " + at +
                     three_digits(100.0 * filter.gain_at(low_pass_hz)) + "% of the sway";
  if (!filter.both_ways)
    text += ", and if it ran forwards only, it delays the sway by " + three_digits(filter.delay_s()) + " s";
  return text + "; give unfiltered recordings";
}

/// Values that are held: samples of a slow sensor, repeated to the rate of the file.
struct Held {
  std::size_t samples = 1;  ///< that each value lasts; 1: none is held
  std::size_t first = 0;    ///< the first sample at which a value begins

  bool is_held() const { return samples > 1; }
  /// Returns the first sample of each value; also of one that began before `first`.
  std::vector<double> values_of(std::span<const double> sway) const {
    std::vector<double> values;
    if (first > 0 && !sway.empty()) values.push_back(sway.front());
    for (std::size_t k = first; k < sway.size(); k += samples) values.push_back(sway[k]);
    return values;
  }
};

/// Finds runs of equal samples that all begin at multiples of one number of samples from each other. At least half of
/// these places must have another value than before: a stretch that stands still holds nothing.
Held find_held(std::span<const double> sway) {
  constexpr std::size_t min_changes = 20;
  std::size_t changes = 0, first = 0, last = 0, common = 0;
  for (std::size_t k = 1; k < sway.size(); ++k) {
    if (sway[k] == sway[k - 1]) continue;
    if (changes++ == 0)
      first = k;
    else if (common = std::gcd(common, k - last); common == 1)
      return {};
    last = k;
  }
  if (changes < min_changes || common < 2 || 2 * changes * common < sway.size()) return {};
  return {common, first % common};
}

/// Returns `held_samples`.
Warnings held_warnings(const Held& held, double rate_hz) {
  Warnings warnings;
  const double length_s = static_cast<double>(held.samples) / rate_hz;
  const auto is_below = [&](double limit_hz) { return length_s * limit_hz > 1.0 + 1e-6; };
  add_warning(warnings,
              is_below(slowest_held_hz) ? Severity::invalid
              : is_below(slow_held_hz)  ? Severity::caution
                                        : Severity::info,
              "held_samples",
              "each value of the sway lasts " + std::to_string(held.samples) + " samples: the sensor's rate is " +
                  six_digits(std::round(1e3 / length_s) / 1e3) + " Hz, and the file repeats its values at " +
                  six_digits(rate_hz) + " Hz; " +
                  (is_below(slowest_held_hz) ? "below 5 Hz it loses the response to the platform: record faster"
                   : is_below(slow_held_hz)  ? "record at 25 Hz or faster"
                                             : "give the sensor's own samples"));
  return warnings;
}

struct Smoothing {
  std::optional<LowPass> low_pass;  ///< that smoothed the sway
  Warnings warnings;                ///< `smooth`, or nothing
};

Smoothing look_for_smoothing(std::span<const double> sway, double rate_hz, double held_s) {
  Smoothing found;
  if (const double length_s = moving_average_s(sway, rate_hz, held_s); length_s > 0.0) {
    add_warning(found.warnings, length_s > trained_average_s * (1.0 + 1e-6) ? Severity::caution : Severity::info,
                "smooth",
                "the sway was smoothed by a moving average of " + three_digits(length_s) +
                    " s, or each value was held for this time: this removes information about the controller, and may "
                    "add to the delay; give unfiltered recordings");
    found.low_pass = moving_average(static_cast<int>(std::lround(length_s * rate_hz)), rate_hz);
    return found;
  }
  found.low_pass = find_low_pass(sway, rate_hz);
  if (found.low_pass) {
    add_warning(found.warnings, removes_much(*found.low_pass) ? Severity::caution : Severity::info, "smooth",
                describe(*found.low_pass));
  } else if (rate_hz >= noise_rate_hz && measurement_noise_deg(sway, rate_hz) < smooth_deg) {
    add_info(found.warnings, "smooth",
             "the sway has no measurement noise above 12 Hz: it was simulated, or smoothed; smoothing adds to the "
             "delay, so give unfiltered recordings");
  }
  return found;
}

}  // namespace

FoundInSway look_for_faults(std::span<const double> sway_rad, double rate_hz, double begin_s, double held_s,
                            std::span<const SampleRange> known) {
  if (static_cast<double>(sway_rad.size()) < min_sway_s * rate_hz || sway_rad.size() < min_samples) return {};
  Stretches found = find_stretches(sway_rad, rate_hz);
  std::erase_if(found.straight, [&](const SampleRange& stretch) {
    return std::ranges::any_of(known, [&](const SampleRange& gap) {  // a bend may be straight by chance on either side
      return stretch.first + 2 >= gap.first && stretch.end <= gap.end + 2;
    });
  });
  const StretchesText frozen = describe(found.frozen, sway_rad.size(), rate_hz, begin_s),
                      bridged = describe(found.straight, sway_rad.size(), rate_hz, begin_s);
  Warnings warnings;
  if (!frozen.text.empty())
    add_warning(warnings, frozen.is_caution ? Severity::caution : Severity::info, "frozen",
                "the sway stands still in " + frozen.text + "the sensor froze, or samples were repeated");
  if (!bridged.text.empty())
    add_warning(warnings, bridged.is_caution ? Severity::caution : Severity::info, "bridged",
                "the sway is a straight line in " + bridged.text + "samples were lost and interpolated");
  const double step = find_step(sway_rad), degrees = step / sim::rad_per_deg;
  if (step > 0.0)
    add_warning(
        warnings, degrees >= coarse_deg * (1.0 - 1e-6) ? Severity::caution : Severity::info, "coarse_steps",
        "the sway has steps of " + three_digits(degrees) + " degrees: the sensor is coarse, or the file was rounded");
  const Held held = find_held(sway_rad);
  if (held.is_held()) append(warnings, held_warnings(held, rate_hz));
  // Values that are held jump by nature, so decid looks at the sensor's own samples.
  const std::vector<double> own = held.is_held() ? held.values_of(sway_rad) : std::vector<double>();
  const std::span<const double> sway = held.is_held() ? std::span<const double>(own) : sway_rad;
  const double own_hz = rate_hz / static_cast<double>(held.samples);
  append(warnings, look_for_spikes(sway, own_hz, step, begin_s));
  append(warnings, look_for_jumps(sway, own_hz, step, begin_s));
  Smoothing smoothing = look_for_smoothing(sway, own_hz, held_s);
  append(warnings, std::move(smoothing.warnings));
  return {std::move(found.unmeasured), smoothing.low_pass, std::move(warnings)};
}

}  // namespace decid::recording
