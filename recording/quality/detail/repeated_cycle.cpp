// A cycle that was copied: see repeated_cycle.hpp.
#include "recording/quality/detail/repeated_cycle.hpp"

#include <algorithm>
#include <cmath>

#include "sim/protocol/protocol.hpp"

namespace decid::recording {

void look_for_repeated_cycle(std::span<const double> sway_rad, const sim::Experiment& experiment, Warnings& warnings) {
  constexpr double same_rad = 1e-5 * sim::rad_per_deg, others = 0.02;
  if (experiment.cycles() < 2) return;
  const auto samples_of = [&](double time_s) {
    return static_cast<std::size_t>(std::round(time_s * experiment.sample_rate_hz));
  };
  const std::size_t begin = samples_of(experiment.lead_in_s()), length = samples_of(experiment.cycle_s());
  if (length == 0 || begin + 2 * length > sway_rad.size()) return;
  const std::span<const double> first = sway_rad.subspan(begin, length), second = sway_rad.subspan(begin + length);
  const auto most = static_cast<std::size_t>(others * static_cast<double>(length));
  std::size_t different = 0;
  for (std::size_t k = 0; k < length; ++k)
    if (std::abs(second[k] - first[k]) > same_rad && ++different > most) return;
  const auto [low, high] = std::ranges::minmax(first);
  if (high - low <= same_rad) return;
  add_caution(warnings, "repeated_cycle",
              "the second cycle of the sway is a copy of the first one: it is one cycle, or the mean of several, and "
              "not the recording; a mean has less of the body's own sway, so the sensory noise is too small; give the "
              "cycles as they were recorded");
}

}  // namespace decid::recording
