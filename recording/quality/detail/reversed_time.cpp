// A sway that runs backwards: see reversed_time.hpp.
#include "recording/quality/detail/reversed_time.hpp"

#include <algorithm>
#include <vector>

#include "base/setting.hpp"
#include "recording/quality/detail/response_check.hpp"

namespace decid::recording {

Warnings look_for_reversed_time(std::span<const double> sway_rad, double response_gain, const ProtocolPlan& plan) {
  // No alarm in 9,000 sound trials of seven protocols, three controllers and two levels of sensory noise.
  constexpr double min_difference = 30.0, min_ratio = 2.0, max_shift_s = 3.0;
  const ResponseCheck& check = plan.response();
  const std::vector<double> reversed(sway_rad.rbegin(), sway_rad.rend());
  const double backwards = check.prediction_of(reversed).gain;
  const auto explains = [&](double gain) { return backwards < gain + min_difference || backwards < min_ratio * gain; };
  if (explains(response_gain)) return {};
  for (double shift_s = -max_shift_s; shift_s <= max_shift_s; shift_s += 1.0)
    if (explains(check.prediction_of(sway_rad, shift_s).gain)) return {};
  return {{Severity::invalid, "time_reversed",
           "the sway follows the tilt backwards in time: its samples are in reverse order, or the platform played its "
           "tilt backwards; give the samples in the order of time, or give " +
               setting("protocol") + " with the tilt that was played"}};
}

}  // namespace decid::recording
