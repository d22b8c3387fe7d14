// Slips of time by the measured tilt: see tilt_slips.hpp.
#include "recording/detail/tilt/tilt_slips.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "base/setting.hpp"
#include "recording/detail/tilt/tilt_match.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {
namespace {

constexpr std::size_t part_count = 8;
constexpr double noticed_slip_s = 0.1, min_part_s = 5.0, min_part_correlation = 0.95, max_gap_fraction = 0.25;

struct Slip {
  double begin_s = 0.0, middle_s = 0.0;  ///< of a part, in the protocol
  double slip_s = 0.0;                   ///< by how much the measured tilt is early
};

/// Returns the slips of the parts that follow the protocol well.
std::vector<Slip> slips_of(const std::vector<double>& tilt, std::span<const SampleRange> gaps,
                           const std::vector<double>& expected, double rate) {
  const std::size_t length = tilt.size() / part_count,
                    around = std::min(length / 4, static_cast<std::size_t>(3.0 * rate));
  if (static_cast<double>(length) < min_part_s * rate) return {};
  std::vector<Slip> slips;
  for (std::size_t part = 0; part < part_count; ++part) {
    // The first and last parts are shorter, so that the prescribed tilt reaches as far beyond every part.
    const std::size_t begin = std::max(part * length, around);
    const std::size_t end = std::min((part + 1) * length, expected.size() - around);
    const std::size_t from = begin - around, to = end + around;
    std::size_t missing = 0;
    for (const SampleRange& gap : gaps)
      missing += std::min(std::max(gap.end, begin), end) - std::min(std::max(gap.first, begin), end);
    if (static_cast<double>(missing) > max_gap_fraction * static_cast<double>(end - begin)) continue;
    const std::vector<double> played(tilt.begin() + static_cast<std::ptrdiff_t>(begin),
                                     tilt.begin() + static_cast<std::ptrdiff_t>(end));
    const std::vector<double> about(expected.begin() + static_cast<std::ptrdiff_t>(from),
                                    expected.begin() + static_cast<std::ptrdiff_t>(to));
    const Match match = TiltMatcher(played, 0).match(about);
    if (match.correlation < min_part_correlation) continue;
    slips.push_back({static_cast<double>(part * length) / rate, static_cast<double>(begin + end) / (2.0 * rate),
                     (match.delay_samples + static_cast<double>(from) - static_cast<double>(begin)) / rate});
  }
  return slips;
}

/// Returns the slope of slips that lie on a line, if they change by more than max_slip_s along it.
std::optional<double> slope_of(const std::vector<Slip>& slips, double max_slip_s) {
  constexpr std::size_t min_slips = 5;
  constexpr double max_off = 0.1;  // of the change along the line; a single step is farther off
  if (slips.size() < min_slips) return {};
  double mean_s = 0.0, mean_slip = 0.0, product = 0.0, square = 0.0;
  for (const Slip& slip : slips) {
    mean_s += slip.middle_s / static_cast<double>(slips.size());
    mean_slip += slip.slip_s / static_cast<double>(slips.size());
  }
  for (const Slip& slip : slips) {
    product += (slip.middle_s - mean_s) * (slip.slip_s - mean_slip);
    square += (slip.middle_s - mean_s) * (slip.middle_s - mean_s);
  }
  const double slope = product / square, change = std::abs(slope * (slips.back().middle_s - slips.front().middle_s));
  if (change <= max_slip_s) return {};
  for (const Slip& slip : slips)
    if (std::abs(slip.slip_s - mean_slip - slope * (slip.middle_s - mean_s)) > max_off * change) return {};
  return slope;
}

Warning clock_warning(double slope, double from_hz) {
  // Parts give the rate to about 1e-4 of it: a whole number so near is likelier.
  double rate_hz = from_hz / (1.0 + slope);
  if (std::abs(std::round(rate_hz) - rate_hz) < 2e-4 * rate_hz) rate_hz = std::round(rate_hz);
  return {Severity::caution, "clock_differs",
          "by the measured tilt the recording's clock runs " + three_digits(100.0 * std::abs(slope)) + "% too " +
              (slope < 0.0 ? "fast" : "slowly") + ": give " + setting("rate") + " " + six_digits(rate_hz) +
              " instead of " + six_digits(from_hz) + " Hz"};
}

/// max_slip_s: smaller slips are ignored.
Warnings slip_warnings(const std::vector<Slip>& slips, double max_slip_s, bool start_was_given) {
  for (std::size_t i = 1; i < slips.size(); ++i) {
    const auto step = [&](std::size_t k) { return slips[k].slip_s - slips[k - 1].slip_s; };
    if (std::abs(step(i)) <= max_slip_s) continue;
    // A part with the step has a slip between those before and after it.
    std::size_t last = i;
    while (last + 1 < slips.size() && step(last + 1) * step(i) > 0.0 && std::abs(step(last + 1)) > 0.5 * max_slip_s)
      ++last;
    const double slip_s = slips[last].slip_s - slips[i - 1].slip_s;
    return {{Severity::caution, "time_slips",
             "after about " + three_digits(slips[i].begin_s) + " s of the protocol the measured tilt is " +
                 three_digits(std::abs(slip_s)) + " s " +
                 (slip_s > 0.0 ? "earlier than before: a stretch of the recording is missing"
                               : "later than before: a stretch was recorded twice")}};
  }
  if (!start_was_given || slips.empty() || !(std::abs(slips.front().slip_s) > max_slip_s)) return {};
  return {{Severity::caution, "time_slips",
           "the measured tilt is " + three_digits(std::abs(slips.front().slip_s)) + " s " +
               (slips.front().slip_s > 0.0 ? "early" : "late") + ": check " + setting("begin")}};
}

}  // namespace

Warnings look_for_tilt_slips(const std::vector<double>& tilt, std::span<const SampleRange> gaps,
                             const ProtocolPlan& plan, double from_hz, bool start_was_given) {
  const double rate = plan.protocol().experiment.sample_rate_hz;
  const std::vector<Slip> slips = slips_of(tilt, gaps, plan.tilt_rad(), rate);
  // Delays are not known better than to a sample.
  const double max_slip_s = std::max(noticed_slip_s, 1.0 / std::min(rate, from_hz));
  if (const std::optional<double> slope = slope_of(slips, max_slip_s)) return {clock_warning(*slope, from_hz)};
  return slip_warnings(slips, max_slip_s, start_was_given);
}

}  // namespace decid::recording
