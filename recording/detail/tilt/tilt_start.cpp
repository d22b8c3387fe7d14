// The protocol's start by the measured tilt of the platform: see tilt_start.hpp.
#include "recording/detail/tilt/tilt_start.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/math/statistics.hpp"
#include "base/setting.hpp"
#include "recording/detail/placement.hpp"
#include "recording/detail/recording_name.hpp"
#include "recording/detail/tilt/tilt_gaps.hpp"
#include "recording/detail/tilt/tilt_match.hpp"
#include "recording/resample.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {
namespace {

constexpr double min_correlation = 0.5;
constexpr double min_rest_fraction = 0.49;  ///< of the protocol: half, less some samples
constexpr double min_before_s = 1.0, max_before_s = 10.0;
constexpr double rest_fraction = 0.01;     // of the protocol's tilt, variances
constexpr double noise_fraction = 0.5;     // of the measurement noise: its variance over one second is known to 14%
constexpr double alike_correlation = 0.9;  // correlation

enum class TiltBefore {
  unknown,  ///< the tilt begins less than 1 s before
  at_rest,
  cycle_end,     ///< the platform played the end of the protocol's last cycle
  another_tilt,  ///< the platform moved differently
};

double covariance(std::span<const double> a, std::span<const double> b) {
  const double mean_a = mean(a), mean_b = mean(b);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - mean_a) * (b[i] - mean_b);
  return sum / static_cast<double>(a.size());
}

/// Returns the variance, from `first` on, that the protocol's tilt does not explain.
double noise_variance(std::span<const double> measured, std::size_t first, std::span<const double> expected,
                      double gain) {
  std::vector<double> rest;
  for (std::size_t i = 0; i < expected.size() && first + i < measured.size(); ++i)
    rest.push_back(measured[first + i] - gain * expected[i]);
  return rest.empty() ? 0.0 : covariance(rest, rest);
}

/// Classifies the platform's movement before the protocol's start. `measured`: the tilt at the protocol's rate.
/// `start`: the sample of it at which the protocol starts. `expected`: the protocol's tilt. `gain`: measured over
/// expected tilt.
TiltBefore tilt_before(std::span<const double> measured, double start, std::span<const double> expected, double gain,
                       double rate_hz) {
  const double samples =
      std::min({std::floor(start + 0.5), max_before_s * rate_hz, static_cast<double>(expected.size())});
  if (samples < min_before_s * rate_hz) return TiltBefore::unknown;
  const auto count = static_cast<std::size_t>(samples);
  const auto first = static_cast<std::size_t>(std::floor(start + 0.5));
  const std::span<const double> before = measured.subspan(first - count, count);
  const std::span<const double> end = expected.last(count);
  const double noise = noise_variance(measured, first, expected, gain);
  const double moved = covariance(before, before) - noise, of_end = covariance(end, end);
  const double of_protocol = gain * gain * covariance(expected, expected);
  if (moved <= rest_fraction * of_protocol + noise_fraction * noise) return TiltBefore::at_rest;
  const bool follows = of_end > 0.0 && covariance(before, end) >= alike_correlation * std::sqrt(moved * of_end);
  return follows ? TiltBefore::cycle_end : TiltBefore::another_tilt;
}

/// Thrown if the platform played another stimulus.
class OtherStimulus : public Error {
  using Error::Error;
};

/// The place of `short`'s sequence in the published COMTEST stimulus, examples/comtest.json.
constexpr double comtest_offset_s = 9.12;

/// Throws OtherStimulus for a tilt that follows COMTEST's stimulus better than the protocol `short`, whose sequence is
/// the same from another place: `short` inverted and 0.88 s later is nearly COMTEST's (correlation 0.9988).
void refuse_comtest(const Signal<double>& tilt, const std::vector<double>& measured, const sim::Protocol& protocol,
                    double correlation, const Recording& recording) {
  if (!protocol.experiment.is_same_but_body(sim::short_protocol().experiment)) return;
  sim::Protocol comtest = protocol;
  comtest.sequence().offset_s = comtest_offset_s;
  const std::vector<double> expected = prescribed_tilt(comtest);
  const Match match = TiltMatcher(expected, static_cast<int>(overhang_of(expected.size()))).match(measured);
  if (match.correlation < good_correlation || match.correlation < std::abs(correlation)) return;
  throw OtherStimulus(
      Code::protocol_mismatch, where(recording),
      "the tilt " + tilt.column + " follows the published COMTEST stimulus (correlation " +
          six_digits(std::round(1e4 * match.correlation) / 1e4) + " from " +
          three_digits(match.delay_samples / protocol.experiment.sample_rate_hz) + " s), not the protocol '" +
          protocol.name + "', which begins elsewhere in the same sequence",
      either(recording, "use a model for examples/comtest.json",
             "give comtest.json of decid's examples as " + setting("protocol") + " to a fit, or give a model for it"));
}

/// Returns the samples between the rests at both ends: those from the first to the last that is farther than a tenth of
/// the tilt's range from its value at that end. Returns no samples for a constant tilt.
SampleRange moving_samples(std::span<const double> tilt) {
  constexpr double rest_range = 0.1;  // sensors of tilt are less noisy
  if (tilt.empty()) return {};
  const auto [lowest, highest] = std::ranges::minmax(tilt);
  const double limit = rest_range * (highest - lowest);
  const auto moves_from = [&](double level) { return [=](double value) { return std::abs(value - level) > limit; }; };
  const auto first = std::find_if(tilt.begin(), tilt.end(), moves_from(tilt.front()));
  const auto last = std::find_if(tilt.rbegin(), tilt.rend(), moves_from(tilt.back()));
  if (first == tilt.end() || last == tilt.rend() || first >= last.base()) return {};
  return {static_cast<std::size_t>(first - tilt.begin()), static_cast<std::size_t>(last.base() - tilt.begin())};
}

/// Throws OtherStimulus for a platform that stood still in the first or last part of a recording, for half of the
/// protocol or more. `measured`: its tilt at the protocol's rate.
void refuse_rest(const Signal<double>& tilt, const std::vector<double>& measured, const sim::Protocol& protocol,
                 const Recording& recording) {
  const double rate = protocol.experiment.sample_rate_hz, needed_s = protocol.duration_s();
  const auto [lowest, highest] = std::ranges::minmax(measured);
  if (highest - lowest <= 1e-9 * std::max(std::abs(lowest), std::abs(highest)))
    throw OtherStimulus(Code::protocol_mismatch, where(recording),
                        "the platform stood still throughout by its tilt " + tilt.column + ", a constant",
                        either(recording, "give another tilt", "name another " + setting("tilt_column")));
  const SampleRange moving = moving_samples(measured);
  if (moving.size() == 0) return;
  const double begin_s = static_cast<double>(moving.first) / rate, end_s = static_cast<double>(moving.end) / rate;
  const double after_s = static_cast<double>(measured.size() - moving.end) / rate;
  if (std::max(begin_s, after_s) < min_rest_fraction * needed_s) return;
  const std::string rest = after_s >= begin_s
                               ? "the platform stopped after " + three_digits(end_s) + " s of the recording"
                               : "the platform stood still for the first " + three_digits(begin_s) + " s";
  throw OtherStimulus(
      Code::protocol_mismatch, where(recording),
      rest + " by its tilt " + tilt.column + ", so it did not play the protocol '" + protocol.name + "' of " +
          six_digits(needed_s) + " s",
      either(recording, "give a recording of the whole protocol, or a model for the protocol that was played",
             "give a recording of the whole protocol, or fit the part that was played: " + to_write(protocol) +
                 ", set its cycles to those that were played, give it a new name, and use it as " +
                 setting("protocol") + " of decid fit"));
}

/// Returns a sentence's beginning with the remedy for a tilt that is `gain` times as large as the protocol's because of
/// its unit; empty for other gains.
std::string unit_remedy(double gain, const Recording& recording) {
  struct UnitOfGain {
    double factor;
    const char *name, *plural;
  };
  for (const UnitOfGain& one : {UnitOfGain{sim::rad_per_deg, "rad", "radians"},
                                {1e3 * sim::rad_per_deg, "mrad", "milliradians"},
                                {1.0 / sim::rad_per_deg, "deg", "degrees"},
                                {1e-3 / sim::rad_per_deg, "deg", "degrees"},
                                {1e3, "mrad", "milliradians"},
                                {1e-3, "rad", "radians"}})
    if (std::abs(gain / one.factor - 1.0) < good_gain)
      return "give " + either(recording, "the tilt's unit", setting("tilt_unit") + " " + one.name) +
             " if the tilt is in " + one.plural + ", as its size suggests; else ";
  return {};
}

/// Throws OtherStimulus if the platform played another stimulus; adds warnings of what differs. `measured`: the tilt at
/// the protocol's rate; at: the place of the match, for texts.
TiltMatch judged(const Signal<double>& tilt, const std::vector<double>& measured, const Match& match,
                 const std::string& at, const sim::Protocol& protocol, Recording& recording) {
  TiltMatch result{match.delay_samples / protocol.experiment.sample_rate_hz, match.correlation,
                   recording.tilt_size_is_unknown ? std::nan("") : match.gain};
  if (match.correlation < min_correlation) refuse_comtest(tilt, measured, protocol, match.correlation, recording);
  const std::string figures = "correlation " + six_digits(std::round(1e4 * match.correlation) / 1e4);
  if (match.correlation < good_correlation && match.correlation > -good_correlation)
    refuse_rest(tilt, measured, protocol, recording);
  // Other movements reach -0.7: half of the protocol, say. The other sign is as certain as a good match.
  if (match.correlation < min_correlation && match.correlation > -good_correlation) {
    throw OtherStimulus(
        Code::protocol_mismatch, where(recording),
        "the tilt " + tilt.column + " does not follow the protocol '" + protocol.name + "' (" + figures + " at " + at +
            ")",
        either(recording, "give another tilt, or a model for the protocol that was played",
               "name another " + setting("tilt_column") + ", or a model for the protocol that was played"));
  }
  if (match.correlation < 0.0) {
    throw OtherStimulus(
        Code::protocol_mismatch, where(recording),
        "the tilt " + tilt.column + " follows the protocol with the other sign (" + figures + ")",
        either(recording, "invert it if only its sensor is mounted in reverse, else invert the sway too",
               "give " + setting("invert") + " tilt if only its sensor is mounted in reverse, or " + setting("invert") +
                   " both if the "
                   "sway is positive in that direction too"));
  }
  if (match.correlation < good_correlation) {
    add_caution(recording.warnings, "tilt_follows_roughly",
                "the tilt " + tilt.column + " follows the protocol only roughly (" + figures +
                    "): its delay may be wrong, or the platform played another stimulus");
  }
  if (std::abs(match.gain - 1.0) > good_gain && !recording.tilt_size_is_unknown) {
    result.is_other_size = true;
    add_caution(
        recording.warnings, "tilt_of_other_size",
        unit_remedy(match.gain, recording) + "the platform tilted " + six_digits(std::round(1e3 * match.gain) / 1e3) +
            " times as far as the protocol prescribes, so these values are biased: analyse with your own protocol (" +
            either(recording, "a fit with a protocol of your amplitude", "decid fit with " + setting("protocol")) +
            "), or check " + either(recording, "the tilt's unit", setting("tilt_unit")));
  }
  return result;
}

}  // namespace

std::vector<double> prescribed_tilt(const sim::Protocol& protocol) {
  return sim::tilt_at_samples(protocol.experiment, sim::make_stimulus(protocol.experiment));
}

std::size_t overhang_of(std::size_t samples) {
  return samples / 4;
}

TiltMatch find_start(const ProtocolPlan& plan, double from_hz, Recording& recording) {
  const sim::Protocol& protocol = plan.protocol();
  const double rate = protocol.experiment.sample_rate_hz;
  const Signal<double>& tilt = recording.signals.at(platform_tilt);
  const std::vector<double>& expected = plan.tilt_rad();
  std::vector<double> measured = resample(tilt.rad, from_hz, rate);
  if (measured.size() + 2 * overhang_of(expected.size()) < expected.size()) refuse_length(recording, protocol, {});
  Match match;
  if (recording.tilt_gaps.empty()) {
    match = plan.tilt().match(measured);
  } else {
    const double start_s = start_beside_gaps(recording, measured, expected, from_hz, rate);
    match = fill_as_prescribed(recording, expected, start_s, from_hz, rate);
    measured = resample(tilt.rad, from_hz, rate);
  }
  TiltMatch result = judged(tilt, measured, match, "best", protocol, recording);
  const TiltBefore before = tilt_before(measured, match.delay_samples, expected, match.gain, rate);
  if (before == TiltBefore::at_rest || before == TiltBefore::cycle_end)
    result.moved_before = before == TiltBefore::cycle_end;
  if (before == TiltBefore::another_tilt)
    add_caution(
        recording.warnings, "moved_before",
        "before the protocol's start the platform moved differently from the end of a cycle: the first seconds contain "
        "the response to that movement");
  return result;
}

namespace {

/// Runs a comparison with a tilt that was found by its name or its values. If it throws, removes the tilt, with a
/// warning.
template <class Compare>
void try_to(const Compare& compare, Recording& recording) {
  try {
    compare();
  } catch (const OtherStimulus& error) {
    add_invalid(recording.warnings, "tilt_not_used",
                "the platform played another stimulus, if this column is its tilt: " + error.problem() + "; " +
                    error.remedy() +
                    either(recording, ", or leave it out",
                           ", or give " + setting("tilt_column") + " none if it is not the tilt"));
    recording.signals.remove(platform_tilt);
  } catch (const Error& error) {
    add_caution(recording.warnings, "tilt_not_used",
                "decid ignores a column that may be the platform's tilt: " + error.problem() + "; " + error.remedy());
    recording.signals.remove(platform_tilt);
  }
}

}  // namespace

std::optional<TiltMatch> try_start(const ProtocolPlan& plan, double from_hz, Recording& recording) {
  const Signal<double>& tilt = *recording.signals.find(platform_tilt);
  std::optional<TiltMatch> match;
  try_to(
      [&] {
        match = find_start(plan, from_hz, recording);
        if (!recording.tilt_was_found_by_values)
          add_info(
              recording.warnings, "tilt_found",
              "the column " + tilt.column + " is assumed to be the platform's tilt and gives the protocol's start");
      },
      recording);
  return match;
}

std::optional<TiltMatch> check_at_start(const ProtocolPlan& plan, double from_hz, double start_s,
                                        Recording& recording) {
  const sim::Protocol& protocol = plan.protocol();
  const double rate = protocol.experiment.sample_rate_hz;
  const Signal<double>& tilt = *recording.signals.find(platform_tilt);
  std::optional<Match> found;
  if (!recording.tilt_gaps.empty()) found = fill_as_prescribed(recording, plan.tilt_rad(), start_s, from_hz, rate);
  std::vector<double> measured = resample(tilt.rad, from_hz, rate);
  // The length was checked: what is missing at the end is the held value.
  const auto begin = std::min(static_cast<std::size_t>(std::lround(start_s * rate)), measured.size() - 1);
  measured.erase(measured.begin(), measured.begin() + static_cast<std::ptrdiff_t>(begin));
  measured.resize(static_cast<std::size_t>(protocol.samples()), measured.back());
  Match match = TiltMatcher(plan.tilt_rad(), 0).match(measured);
  if (found) match = {match.delay_samples, found->correlation, found->gain};
  std::optional<TiltMatch> result;
  try_to([&] { result = judged(tilt, measured, match, "the given start", protocol, recording); }, recording);
  return result;
}

}  // namespace decid::recording
