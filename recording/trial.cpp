// Recordings brought to a protocol: see trial.hpp.
#include "recording/trial.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/error.hpp"
#include "base/math/statistics.hpp"
#include "base/setting.hpp"
#include "recording/detail/placement.hpp"
#include "recording/detail/recording_name.hpp"
#include "recording/detail/sway/sway_axis.hpp"
#include "recording/detail/tilt/tilt_column.hpp"
#include "recording/detail/tilt/tilt_match.hpp"
#include "recording/detail/tilt/tilt_slips.hpp"
#include "recording/detail/tilt/tilt_start.hpp"
#include "recording/quality/detail/changes.hpp"
#include "recording/quality/detail/quality.hpp"
#include "recording/quality/detail/repeated_cycle.hpp"
#include "recording/quality/detail/response_check.hpp"
#include "recording/quality/detail/reversed_time.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {

namespace {

/// The fraction of a trial that may be missing at either end.
constexpr double missing_limit = 0.01;
/// A measured tilt gives the start to a part of a sample: decid does not invent a sample for less than half of one.
constexpr double start_rounding = 0.5;
/// Networks err more on slower recordings: docs/reference/accuracy.md has the measurement.
constexpr double slowest_hz = 5.0, slow_hz = 25.0, slow_margin = 0.02;

/// Throws Error for a rate that loses the response to the platform, and warns of a rate that loses much of it.
void check_rate(Recording& recording, double protocol_hz) {
  const std::string rate = six_digits(recording.rate_hz) + " Hz";
  if (recording.rate_hz < slowest_hz)
    throw Error(
        Code::protocol_mismatch, where(recording),
        "has " + rate + ", too slow for a protocol of " + six_digits(protocol_hz) + " Hz",
        recording.rate_advice.empty() ? "record at 25 Hz or faster; 5 Hz is the slowest rate" : recording.rate_advice);
  if (recording.rate_hz < (1.0 - slow_margin) * slow_hz)
    add_caution(recording.warnings, "slow_rate",
                "the recording has only " + rate +
                    ": below 25 Hz the errors of the parameters are up to 40% larger than for faster recordings");
}

/// Throws Error for a given start that a named tilt defines too, or that lies outside of the recording.
void check_start(const Recording& recording, double start_s, double recorded_s) {
  if (recording.signals.find(platform_tilt) != nullptr && !recording.tilt_was_found)
    throw Error(Code::setting_conflict, where(recording), "a start and a tilt both define the protocol's start",
                either(recording, "give one of them",
                       "give " + setting("begin") + " or " + setting("tilt_column") + ", not both"));
  if (!(start_s >= 0.0 && start_s < recorded_s))
    throw Error(Code::setting_out_of_range, where(recording),
                "the start, " + six_digits(start_s) + " s after the first sample, lies outside of its " +
                    six_digits(recorded_s) + " s",
                either(recording, "give it in seconds after the first sample",
                       "give " + setting("begin") + " in seconds after the recording's first sample"));
}

/// Returns the protocol's samples that a recording covers: from half a sample before the start on, to its end.
TrialPlacement place_trial(double start_s, double recorded_s, const sim::Protocol& protocol) {
  const double rate = protocol.experiment.sample_rate_hz;
  return {start_s, std::max(0LL, static_cast<long long>(std::ceil(-start_s * rate - start_rounding))),
          std::min(static_cast<long long>(protocol.samples()),
                   static_cast<long long>(std::ceil((recorded_s - start_s) * rate - length_rounding))) -
              1};
}

/// Returns true if too many of the `needed` samples are missing at an end, or half of them in all.
bool lacks_much(const TrialPlacement& place, long long needed) {
  const auto max_missing = static_cast<long long>(missing_limit * static_cast<double>(needed));
  return place.first > max_missing || needed - 1 - place.last > max_missing || 2 * (place.last - place.first) < needed;
}

/// Returns the faults of the samples that form the trial; their ranges are those of the recording.
FoundInSway look_for_faults_within(const Recording& recording, double from_hz, const TrialPlacement& place,
                                   const sim::Protocol& protocol) {
  const std::vector<double>& sway = recording.signals.at(com_sway).rad;
  const auto sample_at = [&](long long k) {
    const double at =
        std::round((place.start_s + static_cast<double>(k) / protocol.experiment.sample_rate_hz) * from_hz);
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(sway.size())));
  };
  const auto* sequence = std::get_if<sim::Sequence>(&protocol.experiment.stimulus);
  const std::size_t begin = sample_at(place.first), end = sample_at(place.last + 1);
  const std::span<const double> used = std::span(sway).subspan(begin, end - begin);
  std::vector<SampleRange> gaps = recording.gaps, known;  // known: counted from `begin`
  for (const SampleRange& gap : gaps)
    if (gap.end > begin) known.push_back({std::max(gap.first, begin) - begin, gap.end - begin});
  FoundInSway found = look_for_faults(used, from_hz, static_cast<double>(begin) / from_hz,
                                      sequence != nullptr ? sequence->state_s : 0.0, known);
  for (const SampleRange& stretch : found.unmeasured) gaps.push_back({begin + stretch.first, begin + stretch.end});
  found.unmeasured = joined_ranges(std::move(gaps));
  return found;
}

/// Names the column that may tell recordings apart: with the part of the file that is not used, else in a note. A
/// trigger may also mark the protocol's start, if that is not known and the protocol fits behind it.
void add_change(const sim::Protocol& protocol, bool is_start_known, Recording& recording) {
  constexpr double usual_lack_s = 0.1;  // at the end
  if (recording.change.empty()) return;
  const double recorded_s = static_cast<double>(recording.signals.samples()) / recording.rate_hz;
  if (!is_start_known && recording.change_s && recorded_s - *recording.change_s > protocol.duration_s() - usual_lack_s)
    recording.change +=
        "; if the protocol started there, give " + setting("begin") + " " + six_digits(*recording.change_s);
  const auto part = std::ranges::find_if(recording.warnings, [](const Warning& warning) {
    return one_of(warning.code, {"part_not_used", "starts_before_zero"});
  });
  if (part == recording.warnings.end())
    add_info(recording.warnings, "perhaps_several", recording.change);
  else
    part->text += (part->text.ends_with('.') ? " " : "; ") + recording.change;
}

/// Returns the mean of samples begin .. end - 1.
double mean_of_part(const std::vector<double>& signal, std::size_t begin, std::size_t end) {
  return decid::mean(std::span(signal).subspan(begin, end - begin));
}

/// Subtracts what `kind` names from a trial's sway (see Detrend). Returns a note that says how much; nothing for none.
Warnings detrend(std::vector<double>& sway, const sim::Protocol& protocol, Detrend kind) {
  if (kind == Detrend::none) return {};
  const double rate = protocol.experiment.sample_rate_hz, lead_in_s = protocol.experiment.lead_in_s(),
               cycle_s = protocol.experiment.cycle_s();
  const int cycles = protocol.experiment.cycles();
  const auto sample_at = [&](int cycle) {
    const double at = std::round((lead_in_s + cycle * cycle_s) * rate);
    return std::min(static_cast<std::size_t>(at), sway.size());
  };
  const std::size_t begin = sample_at(0), end = sample_at(cycles);
  double slope = 0.0;  // per sample
  if (kind == Detrend::linear) {
    // Least squares: over the means of the cycles, or over the samples.
    const bool by_cycle = cycles > 1;
    const std::size_t count = by_cycle ? static_cast<std::size_t>(cycles) : end - begin;
    const double middle = 0.5 * (static_cast<double>(count) - 1.0), whole = mean_of_part(sway, begin, end);
    double product = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const double at = static_cast<double>(i) - middle;
      const int cycle = static_cast<int>(i);
      const double value = by_cycle ? mean_of_part(sway, sample_at(cycle), sample_at(cycle + 1)) : sway[begin + i];
      product += at * (value - whole);
      squares += at * at;
    }
    slope = product / squares / (by_cycle ? cycle_s * rate : 1.0);
  }
  for (std::size_t k = 0; k < sway.size(); ++k) sway[k] -= slope * static_cast<double>(k);
  const double offset = mean_of_part(sway, begin, end);
  for (double& value : sway) value -= offset;
  const double drift = slope * static_cast<double>(sway.size());
  return {{Severity::info, "detrended",
           "subtracted: an offset of " + three_digits((offset + 0.5 * drift) / sim::rad_per_deg) + " degrees" +
               (kind == Detrend::linear
                    ? " and a drift of " + three_digits(drift / sim::rad_per_deg) + " degrees over the trial"
                    : "")}};
}

/// Continues a tilt beyond the recording's ends by the prescribed movement: nobody stood on a mirrored tilt.
void continue_as_prescribed(std::span<double> tilt, std::span<const double> prescribed, double gain,
                            const TrialPlacement& place) {
  const auto first = static_cast<std::size_t>(place.first), last = static_cast<std::size_t>(place.last);
  const auto continue_from = [&](std::size_t end, std::size_t k) {
    tilt[k] = tilt[end] + gain * (prescribed[k] - prescribed[end]);
  };
  for (std::size_t k = 0; k < first; ++k) continue_from(first, k);
  for (std::size_t k = last + 1; k < tilt.size(); ++k) continue_from(last, k);
}

/// Returns warnings of a sway that does not continue as it began, or not as the protocol's tilt; sets the trial's
/// response_gain and other_start_s. known: the recording's other warnings.
Warnings check_against_tilt(std::span<const double> sway, const ProtocolPlan& plan, double from_hz,
                            const Warnings& known, Trial& trial) {
  const Prediction prediction = plan.response().prediction_of(sway);
  if (prediction.gain > 0.0) {
    trial.response_gain = prediction.gain;
    // The response to a tilt that began before the recording comes before the taps. A clear one needs no second look.
    constexpr double clear_gain = 60.0;
    for (const double later_s : {0.3, 0.6})
      if (*trial.response_gain < clear_gain)
        trial.response_gain = std::max(*trial.response_gain, plan.response().prediction_of(sway, later_s).gain);
  }
  Changes changes = look_for_changes(plan.response(), sway, trial.gaps, prediction, from_hz, known);
  trial.other_start_s = changes.other_start_s;
  Warnings warnings = std::move(changes.warnings);
  append(warnings, look_for_reversed_time(sway, prediction.gain, plan));
  append(warnings, look_for_repeated_cycle(sway, plan, from_hz));
  return warnings;
}

/// Continues a measured tilt beyond the recording's ends, and warns of its slips.
void complete_tilt(std::vector<double>& tilt, const ProtocolPlan& plan, double from_hz, const TrialPlacement& place,
                   bool start_is_given, const Trial& trial, Recording& recording) {
  const std::optional<TiltMatch>& match = start_is_given ? trial.tilt_at_given_start : trial.tilt;
  continue_as_prescribed(tilt, plan.tilt_rad(), match && !recording.tilt_size_is_unknown ? match->gain : 1.0, place);
  const auto gaps =
      gaps_in_trial(recording.tilt_gaps, from_hz, plan.protocol().experiment.sample_rate_hz, place, tilt.size());
  Warnings slips = look_for_tilt_slips(tilt, gaps, plan, from_hz, start_is_given);
  // The sway shows the same slips less well, and another clock only if the tilt follows the protocol roughly.
  const bool is_clear = match && match->correlation >= good_correlation;
  std::erase_if(recording.warnings, [&](const Warning& warning) {
    return (!slips.empty() && warning.code == "time_slips") || (is_clear && warning.code == "clock_differs");
  });
  append(recording.warnings, std::move(slips));
}

}  // namespace

ProtocolPlan::ProtocolPlan(const sim::Protocol& protocol) : protocol_(protocol), tilt_rad_(prescribed_tilt(protocol)) {}

ProtocolPlan::~ProtocolPlan() = default;

const TiltMatcher& ProtocolPlan::tilt() const {
  // std::call_once would pass exceptions through a function of the C library. A program that contains gcc's unwinder
  // then ends, or hangs with glibc before 2.34.
  const std::lock_guard lock(making_);
  if (!tilt_) {
    tilt_ = std::make_unique<const TiltMatcher>(tilt_rad_, static_cast<int>(overhang_of(tilt_rad_.size())));
  }
  return *tilt_;
}

const ResponseCheck& ProtocolPlan::response() const {
  const std::lock_guard lock(making_);
  if (!response_) {
    const sim::Family& family = protocol_.family();
    const bool has_passive =
        family.varies(sim::Coefficient::kp_pass, 0.0) || family.varies(sim::Coefficient::kd_pass, 0.0);
    response_ = std::make_unique<const ResponseCheck>(tilt_rad_, protocol_.experiment.sample_rate_hz, has_passive);
  }
  return *response_;
}

Trial bring_to_protocol(Recording& recording, const sim::Protocol& protocol, const TrialOptions& options) {
  return bring_to_protocol(recording, ProtocolPlan(protocol), options);
}

Trial bring_to_protocol(Recording& recording, const ProtocolPlan& plan, const TrialOptions& options) {
  if (!recording.other_axes.empty() || !recording.axis_problem.empty()) return bring_axis(plan, options, recording);
  const sim::Protocol& protocol = plan.protocol();
  const double rate = protocol.experiment.sample_rate_hz;
  const auto needed = static_cast<long long>(protocol.samples());
  const bool same_rate = std::abs(recording.rate_hz - rate) <= rate_tolerance * rate;
  const double from_hz = same_rate ? rate : recording.rate_hz;
  const double recorded_s = static_cast<double>(recording.signals.samples()) / from_hz;
  if (recording.rate_hz < rate && !same_rate) check_rate(recording, rate);
  if (!recording.other_columns.empty()) look_for_tilt_by_values(plan, from_hz, recording);
  if (options.start_s) check_start(recording, *options.start_s, recorded_s);
  const Signal<double>* tilt = recording.signals.find(platform_tilt);
  Trial trial;
  trial.is_large = recording.is_large;
  if (tilt && !options.start_s) {
    trial.tilt = recording.tilt_was_found ? try_start(plan, from_hz, recording) : find_start(plan, from_hz, recording);
    tilt = recording.signals.find(platform_tilt);
  }
  const bool is_start_known = options.start_s || trial.tilt;
  double start_s = trial.tilt ? trial.tilt->delay_s : options.start_s.value_or(0.0);
  if (same_rate) start_s = std::round(start_s * rate) / rate;
  // Fixes the length before any other work.
  const TrialPlacement place = place_trial(start_s, recorded_s, protocol);
  if (lacks_much(place, needed))
    refuse_length(recording, protocol, is_start_known ? std::optional(start_s) : std::nullopt);
  if (tilt && options.start_s) {
    trial.tilt_at_given_start = check_at_start(plan, from_hz, *options.start_s, recording);
    tilt = recording.signals.find(platform_tilt);
  }
  const auto samples = static_cast<std::size_t>(needed);
  FoundInSway found = look_for_faults_within(recording, from_hz, place, protocol);
  append(recording.warnings, std::move(found.warnings));
  trial.gaps = gaps_in_trial(found.unmeasured, from_hz, rate, place, samples);
  trial.low_pass = found.low_pass;
  if (!same_rate)
    add_info(recording.warnings, "resampled",
             "resampled from " + six_digits(recording.rate_hz) + " Hz to " + six_digits(rate) + " Hz");
  warn_of_length(recording, protocol, place, is_start_known);
  add_change(protocol, is_start_known, recording);
  const auto add = [&](const Signal<double>& signal, const std::vector<double>& values) {
    trial.signals.add({signal.name, signal.column, std::vector<float>(values.begin(), values.end())});
  };
  const auto cut_out = [&](const Signal<double>& signal) { return cut(signal.rad, from_hz, rate, place, samples); };
  // The sway comes first: complete_tilt() withdraws warnings of it.
  const Signal<double>& recorded_sway = recording.signals.at(com_sway);
  std::vector<double> sway = cut_out(recorded_sway);
  append(recording.warnings, check_against_tilt(sway, plan, from_hz, recording.warnings, trial));
  append(recording.warnings, detrend(sway, protocol, options.detrend));
  add(recorded_sway, sway);
  for (const Signal<double>& signal : recording.signals) {
    if (signal.name == com_sway) continue;
    std::vector<double> values = cut_out(signal);
    if (&signal == tilt)
      complete_tilt(values, plan, from_hz, place, options.start_s.has_value(), trial, recording);
    else
      append(recording.warnings, detrend(values, protocol, options.detrend));
    add(signal, values);
  }
  trial.start_is_doubtful = std::ranges::any_of(recording.warnings, [](const Warning& warning) {
    return warning.severity != Severity::info &&
           one_of(warning.code, {"starts_before_zero", "no_response", "other_start"});
  });
  return trial;
}

Trial make_trial(std::vector<float> sway_rad) {
  Trial trial;
  trial.signals.add({com_sway, "sway", std::move(sway_rad)});
  return trial;
}

}  // namespace decid::recording
