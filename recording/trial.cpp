// Recordings brought to a protocol: its start, rate and length, with offset and drift subtracted.
#include "recording/trial.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/math/statistics.hpp"
#include "base/setting.hpp"
#include "recording/detail/tilt_before.hpp"
#include "recording/detail/tilt_match.hpp"
#include "recording/detail/tilt_rest.hpp"
#include "recording/quality/detail/gaps.hpp"
#include "recording/quality/detail/quality.hpp"
#include "recording/quality/detail/response_check.hpp"
#include "recording/resample.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {

namespace {

/// The fraction of a trial that may be missing at either end.
constexpr double missing_limit = 0.01;
constexpr double min_correlation = 0.5, good_correlation = 0.95, good_gain = 0.1;
constexpr double min_rest_fraction = 0.49;  ///< of the protocol: half, less some samples
/// Networks err more on slower recordings: docs/reference/accuracy.md has the measurement.
constexpr double slowest_hz = 5.0, slow_hz = 25.0, slow_margin = 0.02;
/// The number of samples by which rounding alone may change lengths.
constexpr double rounding = 1e-6;
constexpr double min_gap_s = 0.05;  ///< a straight line through a shorter gap misses the sway by less than its noise

std::string count_at(std::size_t samples, double rate_hz) {
  return std::to_string(samples) + " samples at " + six_digits(rate_hz) + " Hz (" +
         six_digits(static_cast<double>(samples) / rate_hz) + " s)";
}

/// The trial's samples that a recording covers, k = first .. last, and the trial's start in the recording.
struct TrialPlacement {
  double start_s = 0.0;
  long long first = 0, last = -1;
};

std::vector<double> cut(const std::vector<double>& signal, double from_hz, double to_hz, const TrialPlacement& place,
                        std::size_t samples) {
  const auto count = static_cast<std::size_t>(place.last - place.first + 1);
  std::vector<double> inside;
  if (from_hz == to_hz) {
    const auto begin = signal.begin() + static_cast<std::ptrdiff_t>(std::llround(place.start_s * to_hz) + place.first);
    inside.assign(begin, begin + static_cast<std::ptrdiff_t>(count));
  } else {
    const double start_s = place.start_s + static_cast<double>(place.first) / to_hz;
    inside = resample(signal, from_hz, to_hz, start_s, count);
  }
  std::vector<double> result(samples);
  for (std::size_t k = 0; k < samples; ++k) {
    const auto at = static_cast<long long>(k) - place.first;
    const auto end = static_cast<long long>(count) - 1;
    const long long mirrored = at < 0 ? -at : at > end ? 2 * end - at : at;
    result[k] = inside[static_cast<std::size_t>(mirrored)];
  }
  return result;
}

bool in_memory(const Recording& recording) {
  return recording.file.empty();
}

/// Returns seconds as text, to the millisecond.
std::string milliseconds(double seconds) {
  return six_digits(std::floor(seconds * 1e3 + 0.5) / 1e3);
}

std::string where(const Recording& recording) {
  return in_memory(recording) ? "recording" : recording.file;
}

/// Returns the remedy for samples in memory, or for samples of files, which options read.
std::string either(const Recording& recording, const std::string& for_samples, const std::string& for_files) {
  return in_memory(recording) ? for_samples : for_files;
}

/// Returns true if the protocols differ at most in the body.
bool plays(const sim::Protocol& protocol, const sim::Protocol& known) {
  sim::Experiment same_body = known.experiment;
  same_body.body = protocol.experiment.body;
  return same_body == protocol.experiment;
}

/// Returns the advice for writing a protocol like this one with other settings.
std::string to_write(const sim::Protocol& protocol) {
  if (plays(protocol, sim::default_protocol()))
    return "write its protocol (decid stimulus " + setting("write_protocol") + " mine.json)";
  if (plays(protocol, sim::short_protocol()))
    return "write its protocol (decid stimulus " + setting("protocol") + " short " + setting("write_protocol") +
           " mine.json)";
  return "copy its protocol's file";
}

[[noreturn]] void refuse_length(const Recording& recording, const sim::Protocol& protocol, double start_s) {
  const auto needed = static_cast<std::size_t>(protocol.samples());
  const double left_s = static_cast<double>(recording.signals.samples()) / recording.rate_hz - std::max(start_s, 0.0);
  const int cycles = protocol.experiment.cycles();
  const int whole = std::min(
      cycles, static_cast<int>((left_s - protocol.experiment.lead_in_s()) / protocol.experiment.cycle_s() + 1e-9));
  std::string problem = "recording has " + count_at(recording.signals.samples(), recording.rate_hz);
  if (start_s < 0.0) problem += ", which begin " + six_digits(-start_s) + " s after the protocol";
  if (start_s > 0.0) problem += ", " + six_digits(left_s) + " s of them after the start";
  problem +=
      "; the model's protocol '" + protocol.name + "' needs " + count_at(needed, protocol.experiment.sample_rate_hz);
  std::string remedy = "give whole trials of the protocol, or use your own model";
  if (in_memory(recording)) throw Error(Code::recording_too_short, where(recording), problem, remedy);
  if (whole >= 1 && whole < cycles) {
    problem += ", and has only " + std::to_string(whole) + " of its " + std::to_string(cycles) + " whole cycles";
    const double unused_s = left_s - protocol.duration_s() + (cycles - whole) * protocol.experiment.cycle_s();
    if (unused_s > 1.0 / recording.rate_hz) problem += "; the other " + six_digits(unused_s) + " s would not be used";
    remedy = to_write(protocol) + ", set its cycles to " + std::to_string(whole) +
             " and its name to a new one, and give it as " + setting("protocol") + " to a fit, or to a training with " +
             setting("stream") + " for a model";
  } else {
    remedy = "fit it with its own " + setting("protocol") + ", or train a model for that protocol (" +
             setting("stream") + ") and give it as " + setting("model") + "; or give " + setting("rate") +
             " if the time column is wrong";
  }
  throw Error(Code::recording_too_short, where(recording), problem, remedy);
}

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

std::vector<double> prescribed_tilt(const sim::Protocol& protocol) {
  const sim::Stimulus stimulus = sim::make_stimulus(protocol.experiment);
  const int samples = protocol.samples(), steps_per_sample = protocol.experiment.steps_per_sample();
  std::vector<double> tilt;
  tilt.reserve(static_cast<std::size_t>(samples));
  for (int k = 0; k < samples; ++k) tilt.push_back(stimulus.tilt_at(k * steps_per_sample));
  return tilt;
}

/// Returns the number of a protocol's samples that may lie beyond the ends of a measured tilt. It exceeds the allowed
/// number, so that missing samples are reported instead of overlooked.
std::size_t overhang_of(std::size_t samples) {
  return samples / 4;
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
  if (!plays(protocol, sim::short_protocol())) return;
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

/// Throws OtherStimulus for a platform that stood still in the first or last part of a recording, for half of the
/// protocol or more. `measured`: its tilt at the protocol's rate.
void refuse_rest(const Signal<double>& tilt, const std::vector<double>& measured, const sim::Protocol& protocol,
                 const Recording& recording) {
  const double rate = protocol.experiment.sample_rate_hz, needed_s = protocol.duration_s();
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
                 ", set its cycles to those that were played and its name to a new one, and give it as " +
                 setting("protocol") + " to decid fit"));
}

/// Finds the protocol's tilt in the recording's. Throws OtherStimulus if it is missing.
TiltMatch find_start(const Signal<double>& tilt, const ProtocolPlan& plan, double from_hz, Recording& recording) {
  const sim::Protocol& protocol = plan.protocol();
  const double rate = protocol.experiment.sample_rate_hz;
  const auto needed = static_cast<std::size_t>(protocol.samples());
  const std::vector<double> measured = from_hz == rate ? tilt.rad : resample(tilt.rad, from_hz, rate);
  if (measured.size() + 2 * overhang_of(needed) < needed) refuse_length(recording, protocol, 0.0);
  const Match match = plan.tilt().match(measured);
  TiltMatch result{match.delay_samples / rate, match.correlation, match.gain};
  if (match.correlation < min_correlation) refuse_comtest(tilt, measured, protocol, match.correlation, recording);
  const std::string figures = "correlation " + six_digits(std::round(1e4 * match.correlation) / 1e4);
  if (match.correlation < good_correlation && match.correlation > -good_correlation)
    refuse_rest(tilt, measured, protocol, recording);
  // Other movements reach -0.7: half of the protocol, say. The other sign is as certain as a good match.
  if (match.correlation < min_correlation && match.correlation > -good_correlation) {
    throw OtherStimulus(
        Code::protocol_mismatch, where(recording),
        "the tilt " + tilt.column + " does not follow the protocol '" + protocol.name + "' (" + figures + " at best)",
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
  if (std::abs(match.gain - 1.0) > good_gain) {
    result.is_other_size = true;
    add_caution(
        recording.warnings, "tilt_of_other_size",
        "the platform tilted " + six_digits(std::round(1e3 * match.gain) / 1e3) +
            " times as far as the protocol prescribes, so these values are biased: analyse with your own protocol (" +
            either(recording, "a fit with a protocol of your amplitude", "decid fit with " + setting("protocol")) +
            "), or check " + either(recording, "the tilt's unit", setting("tilt_unit")) +
            (std::abs(match.gain / sim::rad_per_deg - 1.0) < good_gain ? ", because these may be radians" : ""));
  }
  const std::vector<double> expected = prescribed_tilt(protocol);
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

/// Warns if a measured tilt follows the protocol with different delays in consecutive parts, as after a missing
/// stretch. `tilt`: at the protocol's samples.
void look_for_tilt_slips(const std::vector<double>& tilt, const ProtocolPlan& plan, Warnings& warnings) {
  constexpr int parts = 8;
  constexpr double max_slip_s = 0.1, shortest_part_s = 5.0;
  const double rate = plan.protocol().experiment.sample_rate_hz;
  const std::vector<double> expected = prescribed_tilt(plan.protocol());
  const std::size_t length = tilt.size() / parts, around = std::min(length / 4, static_cast<std::size_t>(3.0 * rate));
  if (static_cast<double>(length) < shortest_part_s * rate) return;
  for (std::size_t part = 0; part < parts; ++part) {
    // The part of the recording around this part of the prescribed tilt.
    const std::size_t begin = part * length, from = begin > around ? begin - around : 0;
    const std::size_t to = std::min(begin + length + around, expected.size());
    const std::vector<double> played(tilt.begin() + static_cast<std::ptrdiff_t>(begin),
                                     tilt.begin() + static_cast<std::ptrdiff_t>(begin + length));
    const std::vector<double> about(expected.begin() + static_cast<std::ptrdiff_t>(from),
                                    expected.begin() + static_cast<std::ptrdiff_t>(to));
    const Match match = TiltMatcher(played, 0).match(about);
    const double slip_s = (match.delay_samples + static_cast<double>(from) - static_cast<double>(begin)) / rate;
    if (match.correlation < good_correlation || std::abs(slip_s) <= max_slip_s) continue;
    add_caution(
        warnings, "time_slips",
        "after " + three_digits(static_cast<double>(begin) / rate) + " s of the protocol the measured tilt is " +
            three_digits(std::abs(slip_s)) + " s " +
            (slip_s > 0.0 ? "early: a stretch of the recording is missing" : "late: a stretch was recorded twice"));
    return;
  }
}

/// Tries a tilt that was found by its name only. If it does not follow the protocol, nothing else is known about the
/// stimulus.
std::optional<TiltMatch> try_start(const ProtocolPlan& plan, double from_hz, Recording& recording) {
  const Signal<double>& tilt = *recording.signals.find(platform_tilt);
  try {
    const TiltMatch match = find_start(tilt, plan, from_hz, recording);
    add_info(recording.warnings, "tilt_found",
             "the column " + tilt.column + " is assumed to be the platform's tilt and gives the protocol's start");
    return match;
  } catch (const OtherStimulus& error) {
    add_invalid(recording.warnings, "tilt_not_used",
                "the platform played another stimulus, if this column is its tilt: " + error.problem() + "; " +
                    error.remedy() +
                    either(recording, ", or leave it out",
                           ", or give " + setting("tilt_column") + " none if it is not the tilt"));
    recording.signals.remove(platform_tilt);
    return {};
  } catch (const Error& error) {
    add_caution(recording.warnings, "tilt_not_used",
                "decid ignores a column that may be the platform's tilt: " + error.problem() + "; " + error.remedy());
    recording.signals.remove(platform_tilt);
    return {};
  }
}

/// Looks for faults in the samples that form the trial; the ranges of what it finds are those of the recording.
FoundInSway look_for_faults_within(Recording& recording, double from_hz, const TrialPlacement& place,
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
  FoundInSway found = look_for_faults(used, from_hz, recording.warnings, static_cast<double>(begin) / from_hz,
                                      sequence != nullptr ? sequence->state_s : 0.0, known);
  for (const SampleRange& stretch : found.unmeasured) gaps.push_back({begin + stretch.first, begin + stretch.end});
  found.unmeasured = joined(std::move(gaps));
  return found;
}

/// Returns the gaps among the trial's samples, without short ones. A resampled gap is a sample of the lower rate longer
/// at either end. The samples that the recording lacks are gaps too.
std::vector<SampleRange> gaps_in_trial(const std::vector<SampleRange>& gaps, double from_hz, double rate_hz,
                                       const TrialPlacement& place, std::size_t samples) {
  const double margin = from_hz == rate_hz ? 0.0 : std::max(1.0, rate_hz / from_hz);
  const auto inside = [&](double sample) {
    return static_cast<std::size_t>(std::clamp(sample, 0.0, static_cast<double>(samples)));
  };
  const auto sample_of = [&](std::size_t at) { return (static_cast<double>(at) / from_hz - place.start_s) * rate_hz; };
  std::vector<SampleRange> all;
  for (const SampleRange& gap : gaps) {
    if (static_cast<double>(gap.size()) < min_gap_s * from_hz) continue;
    all.push_back({inside(std::floor(sample_of(gap.first) + rounding - margin)),
                   inside(std::ceil(sample_of(gap.end) - rounding + margin))});
  }
  all.push_back({0, static_cast<std::size_t>(place.first)});
  all.push_back({static_cast<std::size_t>(place.last + 1), samples});
  std::erase_if(all, [&](const SampleRange& gap) {
    return gap.first >= gap.end || static_cast<double>(gap.size()) < min_gap_s * rate_hz;
  });
  return joined(std::move(all));
}

/// Warns of ignored samples of a longer recording and of invented samples of a shorter one.
void warn_of_length(Recording& recording, const sim::Protocol& protocol, const TrialPlacement& place,
                    bool start_was_given) {
  const double recorded_s = static_cast<double>(recording.signals.samples()) / recording.rate_hz;
  const double rate = protocol.experiment.sample_rate_hz, before_s = std::max(place.start_s, 0.0);
  const double after_s = recorded_s - place.start_s - protocol.duration_s();
  const double sample_s = 1.0 / std::min(rate, recording.rate_hz);
  if (before_s > 0.5 * sample_s || after_s > 0.5 * sample_s) {
    std::string text = "the recording lasts " + six_digits(recorded_s) + " s, the protocol '" + protocol.name + "' " +
                       six_digits(protocol.duration_s()) + " s: ";
    if (before_s > 0.5 * sample_s) {
      text += "the first " + milliseconds(before_s) + " s" + (after_s > 0.5 * sample_s ? " and " : " are not used");
    }
    if (after_s > 0.5 * sample_s) text += "the last " + milliseconds(after_s) + " s are not used";
    if (start_was_given) {
      add_info(recording.warnings, "part_not_used", text);
    } else {
      text += either(recording, "; another start selects other samples",
                     "; " + setting("begin") + " SECONDS selects other samples") +
              ". Check that the platform played this protocol.";
      add_caution(recording.warnings, "part_not_used", text);
    }
  }
  const long long lacking = place.first + (protocol.samples() - 1 - place.last);
  if (lacking > 0) {
    add_caution(recording.warnings, "samples_lacking",
                "the recording lacks " + std::to_string(lacking) + (lacking == 1 ? " sample" : " samples") +
                    " of the protocol's " + std::to_string(protocol.samples()) + " at its " +
                    (place.first == 0                       ? "end"
                     : place.last == protocol.samples() - 1 ? "start"
                                                            : "ends") +
                    "; the mirror image of their neighbours replaces them");
  }
}

/// Returns the mean of samples begin .. end - 1.
double mean(const std::vector<double>& signal, std::size_t begin, std::size_t end) {
  return decid::mean(std::span(signal).subspan(begin, end - begin));
}

void detrend(std::vector<double>& sway, const sim::Protocol& protocol, Detrend kind, Warnings& warnings) {
  if (kind == Detrend::none) return;
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
    const double middle = 0.5 * (static_cast<double>(count) - 1.0), whole = mean(sway, begin, end);
    double product = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const double at = static_cast<double>(i) - middle;
      const int cycle = static_cast<int>(i);
      const double value = by_cycle ? mean(sway, sample_at(cycle), sample_at(cycle + 1)) : sway[begin + i];
      product += at * (value - whole);
      squares += at * at;
    }
    slope = product / squares / (by_cycle ? cycle_s * rate : 1.0);
  }
  for (std::size_t k = 0; k < sway.size(); ++k) sway[k] -= slope * static_cast<double>(k);
  const double offset = mean(sway, begin, end);
  for (double& value : sway) value -= offset;
  const double drift = slope * static_cast<double>(sway.size());
  add_info(warnings, "detrended",
           "subtracted: an offset of " + three_digits((offset + 0.5 * drift) / sim::rad_per_deg) + " degrees" +
               (kind == Detrend::linear
                    ? " and a drift of " + three_digits(drift / sim::rad_per_deg) + " degrees over the trial"
                    : ""));
}

}  // namespace

ProtocolPlan::ProtocolPlan(const sim::Protocol& protocol) : protocol_(protocol) {}

ProtocolPlan::~ProtocolPlan() = default;

const TiltMatcher& ProtocolPlan::tilt() const {
  // std::call_once would pass exceptions through a function of the C library. A program that contains gcc's unwinder
  // then ends, or hangs with glibc before 2.34.
  const std::lock_guard lock(making_);
  if (!tilt_) {
    const std::size_t overhang = overhang_of(static_cast<std::size_t>(protocol_.samples()));
    tilt_ = std::make_unique<const TiltMatcher>(prescribed_tilt(protocol_), static_cast<int>(overhang));
  }
  return *tilt_;
}

const ResponseCheck& ProtocolPlan::response() const {
  const std::lock_guard lock(making_);
  if (!response_)
    response_ = std::make_unique<const ResponseCheck>(prescribed_tilt(protocol_), protocol_.experiment.sample_rate_hz);
  return *response_;
}

Trial bring_to_protocol(Recording& recording, const sim::Protocol& protocol, const TrialOptions& options) {
  return bring_to_protocol(recording, ProtocolPlan(protocol), options);
}

Trial bring_to_protocol(Recording& recording, const ProtocolPlan& plan, const TrialOptions& options) {
  const sim::Protocol& protocol = plan.protocol();
  const double rate = protocol.experiment.sample_rate_hz;
  const auto needed = static_cast<long long>(protocol.samples());
  const bool same_rate = std::abs(recording.rate_hz - rate) <= rate_tolerance * rate;
  const double from_hz = same_rate ? rate : recording.rate_hz;
  const double recorded_s = static_cast<double>(recording.signals.samples()) / from_hz;
  if (recording.rate_hz < rate && !same_rate) check_rate(recording, rate);
  if (options.start_s && recording.tilt_was_found) recording.signals.remove(platform_tilt);
  const Signal<double>* tilt = recording.signals.find(platform_tilt);
  if (options.start_s && tilt) {
    throw Error(Code::setting_conflict, where(recording), "a start and a tilt both define the protocol's start",
                either(recording, "give one of them",
                       "give " + setting("begin") + " or " + setting("tilt_column") + ", not both"));
  }
  if (options.start_s && !(*options.start_s >= 0.0 && *options.start_s < recorded_s)) {
    throw Error(Code::setting_out_of_range, where(recording),
                "the start, " + six_digits(*options.start_s) + " s after the first sample, lies outside of its " +
                    six_digits(recorded_s) + " s",
                either(recording, "give it in seconds after the first sample",
                       "give " + setting("begin") + " in seconds after the recording's first sample"));
  }
  Trial trial;
  trial.is_large = recording.is_large;
  TrialPlacement place{options.start_s.value_or(0.0), 0, needed - 1};
  if (tilt) {
    trial.tilt =
        recording.tilt_was_found ? try_start(plan, from_hz, recording) : find_start(*tilt, plan, from_hz, recording);
    tilt = recording.signals.find(platform_tilt);
  }
  if (trial.tilt) place.start_s = trial.tilt->delay_s;
  if (same_rate) place.start_s = std::round(place.start_s * rate) / rate;
  // Fixes the length before any other work: samples k with 0 <= start + k / rate, and before the end.
  place.first = std::max(0LL, static_cast<long long>(std::ceil(-place.start_s * rate - rounding)));
  place.last =
      std::min(needed - 1, static_cast<long long>(std::ceil((recorded_s - place.start_s) * rate - rounding)) - 1);
  const auto most = static_cast<long long>(missing_limit * static_cast<double>(needed));
  if (place.first > most || needed - 1 - place.last > most || 2 * (place.last - place.first) < needed) {
    refuse_length(recording, protocol, place.start_s);
  }
  const auto samples = static_cast<std::size_t>(needed);
  const FoundInSway found = look_for_faults_within(recording, from_hz, place, protocol);
  trial.gaps = gaps_in_trial(found.unmeasured, from_hz, rate, place, samples);
  trial.low_pass = found.low_pass;
  if (!same_rate)
    add_info(recording.warnings, "resampled",
             "resampled from " + six_digits(recording.rate_hz) + " Hz to " + six_digits(rate) + " Hz");
  warn_of_length(recording, protocol, place, options.start_s || trial.tilt);
  for (const Signal<double>& signal : recording.signals) {
    std::vector<double> values = cut(signal.rad, from_hz, rate, place, samples);
    if (signal.name == com_sway) look_for_changes(plan.response(), values, recording.warnings);
    if (&signal == tilt) look_for_tilt_slips(values, plan, recording.warnings);
    if (&signal != tilt) detrend(values, protocol, options.detrend, recording.warnings);
    trial.signals.add({signal.name, signal.column, std::vector<float>(values.begin(), values.end())});
  }
  return trial;
}

Trial make_trial(std::vector<float> sway_rad) {
  Trial trial;
  trial.signals.add({com_sway, "sway", std::move(sway_rad)});
  return trial;
}

}  // namespace decid::recording
