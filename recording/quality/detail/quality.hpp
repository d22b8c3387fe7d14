// Finds traces of sensors, plugs and programs in the samples of a recorded sway. Not installed.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/sample_range.hpp"
#include "base/warning.hpp"
#include "recording/low_pass.hpp"

namespace decid::recording {

/// Findings in the samples of a sway.
struct FoundInSway {
  std::vector<SampleRange> unmeasured;  ///< see Stretches
  std::optional<LowPass> low_pass;      ///< see find_low_pass()
  Warnings warnings;                    ///< one for each fault
};

/// Returns the faults that the sway has; none for signals under two seconds, which are too short. The signal begins
/// `begin_s` after the start of the recording, from which warnings count time:
/// - frozen, bridged: the frozen and the straight stretches of gaps.hpp. A caution if they make up 2% of the signal.
/// `known`: samples that were filled on reading, which are not `bridged` stretches;
/// - coarse_steps: values are multiples of a step of 0.02 degrees or more; a caution from 0.2 degrees;
/// - spikes: single samples off the line between their neighbours, or a first or last sample off the line through the
/// nearest two. The distance exceeds 0.05 degrees, 20 times its median and three steps of a coarse sensor. A caution;
/// - jumps: lines through eight samples before and after a place miss each other by more than 0.1 degrees, twelve times
/// their median and three steps of a coarse sensor, which a body cannot do: occluded markers written as 0, another
/// sensor's samples, stretches that were joined. A caution;
/// - smooth: no measurement noise between 12 and 25 Hz, where sway has no power and sensors have: below 0.0003 degrees
/// by the median of fourth differences of samples averaged to about 50 Hz. The sway was smoothed or simulated. Checked
/// from 50 Hz. Also a moving average (moving_average.hpp) at any rate; a caution beyond 0.25 s, which no model was
/// trained on. Also a low-pass (low_pass.hpp);
/// - held_samples: a slow sensor's values, each of which the file repeats; a caution below 10 Hz,
/// invalid below 5 Hz. The three warnings above are then those of the sensor's own samples, without the copies.
/// held_s: the duration of each state of the platform's tilt, or 0.
FoundInSway look_for_faults(std::span<const double> sway_rad, double rate_hz, double begin_s = 0.0, double held_s = 0.0,
                            std::span<const SampleRange> known = {});

}  // namespace decid::recording
