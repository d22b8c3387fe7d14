// A sway that runs backwards: see reversed_time.hpp.
#include "recording/quality/detail/reversed_time.hpp"

#include <algorithm>
#include <vector>

#include "base/setting.hpp"
#include "recording/quality/detail/response_check.hpp"

namespace decid::recording {

Warnings look_for_reversed_time(std::span<const double> sway_rad, const ProtocolPlan& plan) {
  // None of 3,600 sound trials of the prior, 200 for each of 18 conditions, gains more than 23 by its reverse.
  constexpr double min_difference = 30.0, min_ratio = 1.5, max_shift_s = 3.0;
  const ResponseCheck& check = plan.response();
  const std::vector<double> reversed(sway_rad.rbegin(), sway_rad.rend());
  const double backwards = check.response_of(reversed).gain;
  if (backwards < min_difference) return {};
  const auto explains = [&](double gain) { return backwards < gain + min_difference || backwards < min_ratio * gain; };
  if (explains(check.response_of(sway_rad).gain)) return {};
  for (double shift_s = -max_shift_s; shift_s <= max_shift_s; shift_s += 1.0)
    if (explains(check.response_of(sway_rad, shift_s).gain)) return {};
  // A tilt that explains two thirds of its reverse cannot tell.
  constexpr double max_explained = 2.0;
  const std::vector<double> tilt(plan.tilt_rad().rbegin(), plan.tilt_rad().rend());
  if (check.response_of(tilt).gain > max_explained * static_cast<double>(check.blocks())) return {};
  return {{Severity::invalid, "time_reversed",
           "the sway follows the tilt backwards in time: its samples are in reverse order, or the platform played its "
           "tilt backwards; give the samples in the order of time, or give " +
               setting("protocol") + " with the tilt that was played"}};
}

}  // namespace decid::recording
