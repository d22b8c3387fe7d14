// A cycle that was copied: see repeated_cycle.hpp.
#include "recording/quality/detail/repeated_cycle.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/math/statistics.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {
namespace {

constexpr double same_rad = 1e-5 * sim::rad_per_deg, start_s = 5.0, others = 0.02, as_the_tilt = 0.99;
/// Samples of the lower rate on one side of the resampling filter's middle: resample.hpp. The filter continues the
/// recording before its first sample, but has the first cycle's end before the second.
constexpr double filter_samples = 26.0;

/// Returns true if at most `max_different` samples differ.
bool agree(std::span<const double> a, std::span<const double> b, std::size_t max_different) {
  std::size_t different = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    if (std::abs(b[k] - a[k]) > same_rad && ++different > max_different) return false;
  return true;
}

/// Returns true if the values hardly move, single wrong ones aside.
bool stands_still(std::span<const double> values) {
  constexpr double aside = 0.01;
  std::vector<double> sorted(values.begin(), values.end());
  std::ranges::sort(sorted);
  return quantile_of_sorted(sorted, 1.0 - aside) - quantile_of_sorted(sorted, aside) <= same_rad;
}

}  // namespace

Warnings look_for_repeated_cycle(std::span<const double> sway_rad, const ProtocolPlan& plan, double from_hz) {
  const sim::Experiment& experiment = plan.protocol().experiment;
  if (experiment.cycles() < 2) return {};
  const double rate_hz = experiment.sample_rate_hz;
  const auto samples_of = [&](double time_s) { return static_cast<std::size_t>(std::round(time_s * rate_hz)); };
  const std::size_t begin = samples_of(experiment.lead_in_s()), length = samples_of(experiment.cycle_s());
  if (length == 0 || begin + 2 * length > sway_rad.size()) return {};
  const std::span<const double> first = sway_rad.subspan(begin, length), second = sway_rad.subspan(begin + length);
  const std::size_t start = std::min(samples_of(start_s), length);
  const std::size_t filtered = from_hz == rate_hz ? 0 : samples_of(filter_samples / std::min(from_hz, rate_hz));
  if (!agree(first.first(start), second, filtered)) return {};
  const auto max_different = static_cast<std::size_t>(others * static_cast<double>(length - start));
  if (!agree(first.subspan(start), second.subspan(start), max_different) || stands_still(first)) return {};
  const std::span<const double> tilt = std::span(plan.tilt_rad()).subspan(begin, length);
  if (std::abs(correlation(first, tilt)) > as_the_tilt) return {};
  return {{Severity::caution, "repeated_cycle",
           "the second cycle of the sway is a copy of the first one, as in a mean of cycles that was written twice. A "
           "mean has less of the body's own sway, so the sensory noise is too small. Give the cycles as they were "
           "recorded"}};
}

}  // namespace decid::recording
