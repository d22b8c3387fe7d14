// Finds jumps: see jumps.hpp. Lines are fitted by least squares to eight samples at about 100 Hz.
#include "recording/quality/detail/jumps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "base/math/statistics.hpp"
#include "base/setting.hpp"
#include "recording/quality/detail/block_means.hpp"
#include "recording/table/columns.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {

namespace {

constexpr std::size_t side_samples = 8;  ///< on each side of a jump
constexpr double finest_hz = 100.0;
constexpr double min_deg = 0.1, min_medians = 12.0, min_steps = 3.0;
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
std::size_t longest_zeros(std::span<const double> sway) {
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
  const std::size_t zeros = longest_zeros(sway);
  if (zeros == 0) return "leave wrong stretches empty and give " + setting("fill_gaps") + ", or cut the recording";
  const double longest_s = std::ceil(1e4 * static_cast<double>(zeros) / rate_hz - 1e-6) / 1e4;
  return "if its zeros stand for missing samples (occluded markers), give " + setting("missing") + " 0 and " +
         setting("fill_gaps") + " " + six_digits(longest_s) +
         "; else leave wrong stretches empty, or cut the recording";
}

}  // namespace

void look_for_jumps(std::span<const double> sway_rad, double rate_hz, double step_rad, double begin_s,
                    Warnings& warnings) {
  const std::size_t block = std::max<std::size_t>(1, static_cast<std::size_t>(rate_hz / finest_hz));
  std::vector<double> jumps = jumps_of(smoothed(sway_rad, block));
  if (jumps.size() < 4 * side_samples) return;
  std::vector<double> sizes(jumps.size());
  std::ranges::transform(jumps, sizes.begin(), [](double jump) { return std::abs(jump); });
  const double min_jump =
      std::max({min_deg * sim::rad_per_deg, min_medians * median(std::move(sizes)), min_steps * step_rad});
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
  if (count == 0) return;
  add_caution(warnings, "jumps",
              "the sway jumps in " + std::to_string(count) + (count == 1 ? " place" : " places") + ", by up to " +
                  three_digits(largest / sim::rad_per_deg) + " degrees, the first after " +
                  three_digits(begin_s + static_cast<double>(first * block) / rate_hz) +
                  " s, which a body cannot do: " + remedy_for_jumps(sway_rad, rate_hz));
}

}  // namespace decid::recording
