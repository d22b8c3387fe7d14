// A sway that runs backwards: see reversed_time.hpp.
#include "recording/quality/detail/reversed_time.hpp"

#include <algorithm>
#include <vector>

#include "recording/quality/detail/response_check.hpp"

namespace decid::recording {

void look_for_reversed_time(std::span<const double> sway_rad, const ProtocolPlan& plan, Warnings& warnings) {
  // None of 3,600 trials of the prior, 200 for each of 18 other conditions, gains more than 23 by its reverse.
  constexpr double min_gain = 30.0, min_ratio = 1.5, longest_shift_s = 3.0;
  const ResponseCheck& check = plan.response();
  const std::vector<double> reversed(sway_rad.rbegin(), sway_rad.rend());
  const double backwards = check.response_of(reversed).gain;
  const auto explains = [&](double gain) { return backwards < gain + min_gain || backwards < min_ratio * gain; };
  if (explains(check.response_of(sway_rad).gain)) return;
  for (double shift_s = -longest_shift_s; shift_s <= longest_shift_s; shift_s += 1.0)
    if (explains(check.response_of(sway_rad, shift_s).gain)) return;
  // The ten blocks per second of the check: a tilt that explains two thirds of its reverse cannot tell.
  constexpr double blocks_hz = 10.0, max_explained = 2.0;
  const std::vector<double> tilt(plan.tilt_rad().rbegin(), plan.tilt_rad().rend());
  const double samples = static_cast<double>(tilt.size());
  if (check.response_of(tilt).gain > max_explained * blocks_hz * samples / plan.protocol().experiment.sample_rate_hz)
    return;
  add_invalid(warnings, "time_reversed",
              "the sway follows the tilt backwards in time: its samples are in reverse order, or the platform played "
              "its tilt backwards; give the samples in the order of time");
}

}  // namespace decid::recording
