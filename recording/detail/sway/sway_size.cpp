// The size of a sway: see sway_size.hpp.
#include "recording/detail/sway/sway_size.hpp"

#include <algorithm>
#include <string>

#include "base/error.hpp"
#include "base/math/statistics.hpp"
#include "base/setting.hpp"
#include "recording/detail/recording_name.hpp"
#include "recording/table/columns.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {

namespace {

/// A sway below min_plausible_deg is more likely in radians: quiet stance alone sways more.
constexpr double max_plausible_deg = 20.0, min_plausible_deg = 0.1, max_deg = 90.0;
/// Bounds of a sway whose unit is assumed: beyond them it is more likely in cm, mm or volts.
constexpr double max_assumed_deg = 20.0, max_assumed_sd_deg = 5.0;

/// Warns of a sway that is too large for the degrees in which it was read without a unit.
void check_assumed_unit(const Signal<double>& sway, double peak_to_peak_deg, const std::string& remedy,
                        Recording& recording) {
  const double sd_deg = stddev(sway.rad) / sim::rad_per_deg;
  if (peak_to_peak_deg <= max_assumed_deg && sd_deg <= max_assumed_sd_deg) return;
  recording.is_large = true;
  add_caution(recording.warnings, "large_sway",
              "the name of " + sway.column + " has no unit, and in degrees its standard deviation is " +
                  three_digits(sd_deg) + " and its peak to peak " + three_digits(peak_to_peak_deg) +
                  ", more than a standing body sways; " + remedy);
}

}  // namespace

void refuse_differing_unit(const Recording& recording, const std::string& problem) {
  const auto differs = std::ranges::find(recording.warnings, "unit_differs", &Warning::code);
  if (differs != recording.warnings.end())
    throw Error(Code::value_invalid, where(recording), problem + ": " + differs->text,
                "correct " + setting("unit") + ", or leave it out if the name has the right unit");
}

void check_size(const Signal<double>& sway, bool guessed, bool mean_is_upright, bool of_positions,
                Recording& recording) {
  const std::string other =
      either(recording, "give radians",
             "if the unit is wrong, give " + setting("unit") +
                 (of_positions ? "; check the heights of the positions, and that their axis is the tilt's direction"
                               : "; if these are positions, give " + setting("com_height")));
  const auto [low, high] = std::minmax_element(sway.rad.begin(), sway.rad.end());
  const double middle = mean(sway.rad), upright = mean_is_upright ? middle : 0.0;
  const double peak_deg = std::max(upright - *low, *high - upright) / sim::rad_per_deg;
  const double peak_to_peak_deg = (*high - *low) / sim::rad_per_deg;
  if (*low == *high) {
    throw Error(Code::value_invalid, where(recording),
                sway.column + " is constant, " + three_digits(*high / sim::rad_per_deg + 0.0) + " degrees",
                either(recording, "give samples of sway", "name the sway column with " + setting("column")));
  }
  if (peak_deg > max_deg) {
    refuse_differing_unit(recording,
                          sway.column + " reaches " + three_digits(peak_deg) + " degrees, beyond lying flat");
    const auto at = (upright - *low > *high - upright ? low : high) - sway.rad.begin();
    if (!in_memory(recording) && peak_to_peak_deg < 2.0 * max_plausible_deg)
      throw Error(Code::value_invalid, where(recording),
                  sway.column + " is about " + three_digits(middle / sim::rad_per_deg) + " degrees, beyond lying flat",
                  "if that is upright, give " + setting("detrend") + " offset; " + other);
    throw Error(Code::value_invalid, where(recording),
                sway.column + " reaches " + three_digits(peak_deg) + " degrees, beyond lying flat, at sample " +
                    std::to_string(at + 1),
                in_memory(recording) ? other
                                     : other + std::string("; if it stands for a missing value, give " +
                                                           setting("missing") + " NUMBER and " + setting("fill_gaps")));
  }
  if (peak_deg > max_plausible_deg) {
    recording.is_large = true;
    add_caution(recording.warnings, "large_sway",
                "the sway reaches " + three_digits(peak_deg) + " degrees, too far for a standing body; " + other);
  } else if (guessed) {
    check_assumed_unit(sway, peak_to_peak_deg, other, recording);
  }
  const double if_radians_deg = peak_to_peak_deg / sim::rad_per_deg;
  if (guessed && peak_to_peak_deg < min_plausible_deg && if_radians_deg > min_plausible_deg)
    throw Error(Code::unit_unknown, where(recording),
                sway.column + " has no unit, and is " + three_digits(peak_to_peak_deg) +
                    " degrees peak to peak if it is in degrees, " + three_digits(if_radians_deg) + " if in radians",
                "give " + setting("unit") + " rad or " + setting("unit") + " deg; if these are positions, give " +
                    setting("com_height"));
  if (peak_to_peak_deg < min_plausible_deg) {
    add_caution(recording.warnings, "small_sway",
                "the sway is only " + three_digits(peak_to_peak_deg) + " degrees peak to peak, " +
                    three_digits(if_radians_deg) + " if these are radians; " + other);
  }
}

}  // namespace decid::recording
