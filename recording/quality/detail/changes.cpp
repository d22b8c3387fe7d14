// Warnings of a sway that does not continue as it began: see changes.hpp.
#include "recording/quality/detail/changes.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/setting.hpp"
#include "base/text.hpp"
#include "recording/table/columns.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {

namespace {

constexpr double off_deg = 0.3, off_medians = 14.0, slip_gain = 50.0, rest_gain = 26.0;
/// A weak response is fitted to noise, whose clock gain is larger by chance, and a first order holds for small errors.
/// One of 13,000 sound trials, with each fault of recordings, is above these limits.
constexpr double clock_gain = 14.0, min_clock_response = 60.0, max_clock_error = 0.01;
constexpr double inferable_start_s = 0.6;  ///< a fit infers up to 0.5 s; starts are found in steps of 0.2 s
constexpr double movement_deg = 0.3, movement_deviations = 8.0;
constexpr double around_s = 1.0;  ///< what a user empties on both sides of a movement, together

std::string describe(const Movement& movement) {
  const std::string size = three_digits(std::abs(movement.size) / sim::rad_per_deg) + " degrees",
                    unexplained = ", which neither the tilt nor this sway's noise explains: ",
                    from = three_digits(movement.begin_s), to = three_digits(movement.end_s);
  if (movement.is_step)
    return "about " + three_digits(0.5 * (movement.begin_s + movement.end_s)) +
           " s after the protocol's start the sway moves to another level, by " + size + unexplained +
           "if the person stood differently from then on, or the sensor slipped, repeat the trial";
  const std::string fill = setting("fill_gaps") + " ";
  if (movement.begin_s <= 0.0)
    return "in the protocol's first " + to + " s the sway moves by " + size + unexplained +
           "if the person had not settled, leave the sway's values empty until the person stands as later, and give " +
           fill + "with the length of this gap, or repeat the trial";
  return "from " + from + " to " + to + " s of the protocol the sway moves by " + size + unexplained +
         "if the person staggered or was held, leave the sway's values in this stretch and half a second on both sides "
         "empty, and give " +
         fill + three_digits(std::ceil(movement.end_s - movement.begin_s + around_s)) + "; else repeat the trial";
}

}  // namespace

Changes look_for_changes(const ResponseCheck& check, std::span<const double> sway_rad,
                         std::span<const SampleRange> gaps, const Prediction& prediction, double from_hz,
                         const Warnings& known) {
  Changes changes;
  Warnings& warnings = changes.warnings;
  const ResponseCheck::Found found = check.check(sway_rad, gaps);
  const bool is_known = std::ranges::any_of(known, [](const Warning& warning) {
    return one_of(warning.code, {"jumps", "spikes", "frozen"});
  });
  const bool is_off = found.medians > off_medians && found.innovation_rad > off_deg * sim::rad_per_deg;
  const bool moves = !is_known && !is_off && found.movement.deviations > movement_deviations &&
                     std::abs(found.movement.size) > movement_deg * sim::rad_per_deg;
  if (!is_known && is_off)
    add_caution(warnings, "stretch_off",
                three_digits(found.innovation_at_s) + " s after the protocol's start the sway moves by " +
                    three_digits(found.innovation_rad / sim::rad_per_deg) + " degrees within 0.1 s, " +
                    three_digits(found.medians) + " times as far as it usually does: check the sensor there");
  if (moves) add_caution(warnings, "unusual_movement", describe(found.movement));
  // A person who settles at the start hides the response there, or imitates one that then ends.
  const bool settles = moves && found.movement.begin_s <= 0.0;
  if (!settles && found.rest_gain > rest_gain && found.rest_gain > std::max(found.shift_gain, found.slip_gain)) {
    add_caution(warnings, "no_response",
                "from " + three_digits(found.rest_begin_s) + " to " + three_digits(found.rest_end_s) +
                    " s of the protocol the sway does not follow the tilt, and otherwise it does: the platform stood "
                    "still there, or the sensor failed; give the part with the tilt and its protocol");
    return changes;
  }
  const bool slips = found.slip_gain > slip_gain, is_shifted = slips && found.shift_gain > found.slip_gain;
  if (is_shifted || (!slips && found.early_s > 0.0)) {
    const double start_s = is_shifted ? found.shift_s : -found.early_s;
    const bool late = start_s > 0.0;
    add_caution(warnings, "other_start",
                "the sway follows the tilt as if the recording started " + three_digits(std::abs(start_s)) + " s " +
                    (late ? "after" : "before") + " the protocol: " +
                    (late ? "give a recording from the protocol's start on"
                          : "give the protocol's start as " + setting("begin")) +
                    (std::abs(start_s) <= inferable_start_s
                         ? ", or let a fit without a measured tilt infer it (" + setting("prior_start") + " 0.5)"
                         : ""));
    changes.other_start_s = start_s;
    return changes;
  }
  // A clock that is a little off looks like a slip, and a slip like such a clock; each explains its own sway best.
  if (prediction.clock_gain > std::max(clock_gain, found.slip_gain) && prediction.gain > min_clock_response &&
      std::abs(prediction.clock_error) < max_clock_error)
    add_caution(
        warnings, "clock_differs",
        "the sway follows the tilt as if the recording's clock ran about " +
            format("%.2g", 100.0 * std::abs(prediction.clock_error)) + "% too " +
            (prediction.clock_error < 0.0 ? "fast" : "slowly") + ": check whether it has lost samples, and " +
            setting("rate") +
            format(", which would be %.4g instead of %.4g Hz", from_hz / (1.0 + prediction.clock_error), from_hz));
  else if (slips)
    add_caution(warnings, "time_slips",
                "after " + three_digits(found.slip_at_s) + " s of the protocol the sway follows the tilt " +
                    three_digits(std::abs(found.slip_s)) + " s " + (found.slip_s > 0.0 ? "earlier" : "later") +
                    " than before: " +
                    (found.slip_s > 0.0 ? "a stretch of the recording is probably missing"
                                        : "a stretch was probably recorded twice"));
  return changes;
}

}  // namespace decid::recording
