// The part of a recording that is a trial of a protocol: see placement.hpp.
#include "recording/detail/placement.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "recording/detail/recording_name.hpp"
#include "recording/resample.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {
namespace {

/// More or fewer samples at the end, of an export that includes the last instant, say nothing about the start.
constexpr double usual_excess_s = 0.1;
constexpr double min_gap_s = 0.05;  ///< a straight line through a shorter gap misses the sway by less than its noise

std::string count_at(std::size_t samples, double rate_hz) {
  return std::to_string(samples) + " samples at " + six_digits(rate_hz) + " Hz (" +
         six_digits(static_cast<double>(samples) / rate_hz) + " s)";
}

/// Returns the time 0 of a file whose times begin before it, in seconds after its first sample, if the protocol fits
/// behind it and the file is longer than the protocol.
std::optional<double> zero_behind_start(const Recording& recording, const sim::Protocol& protocol) {
  constexpr double min_zero_s = 0.1;
  const double zero_s = -recording.first_time_s, duration_s = protocol.duration_s();
  const double recorded_s = static_cast<double>(recording.signals.samples()) / recording.rate_hz;
  const double sample_s = 1.0 / std::min(protocol.experiment.sample_rate_hz, recording.rate_hz);
  if (zero_s < min_zero_s || recorded_s - duration_s <= usual_excess_s * (1.0 + 1e-9)) return {};
  if (recorded_s - zero_s < duration_s - sample_s * (1.0 + length_rounding)) return {};
  return zero_s;
}

/// Returns seconds as text, to the millisecond.
std::string milliseconds(double seconds) {
  return six_digits(std::floor(seconds * 1e3 + 0.5) / 1e3);
}

/// Returns how many whole cycles lie between two times after the protocol's start.
int whole_cycles(const sim::Experiment& experiment, double first_s, double last_s) {
  const auto cycle_at = [&](double at_s) { return (at_s - experiment.lead_in_s()) / experiment.cycle_s(); };
  const double first = std::max(std::ceil(cycle_at(first_s) - 1e-9), 0.0);
  const double last = std::min(std::floor(cycle_at(last_s) + 1e-9), static_cast<double>(experiment.cycles()));
  return static_cast<int>(std::max(last - first, 0.0));
}

}  // namespace

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
    all.push_back({inside(std::floor(sample_of(gap.first) + length_rounding - margin)),
                   inside(std::ceil(sample_of(gap.end) - length_rounding + margin))});
  }
  all.push_back({0, static_cast<std::size_t>(place.first)});
  all.push_back({static_cast<std::size_t>(place.last + 1), samples});
  std::erase_if(all, [&](const SampleRange& gap) {
    return gap.first >= gap.end || static_cast<double>(gap.size()) < min_gap_s * rate_hz;
  });
  return joined_ranges(std::move(all));
}

std::string to_write(const sim::Protocol& protocol) {
  if (protocol.experiment.is_same_but_body(sim::default_protocol().experiment))
    return "write its protocol (decid stimulus " + setting("write_protocol") + " mine.json)";
  if (protocol.experiment.is_same_but_body(sim::short_protocol().experiment))
    return "write its protocol (decid stimulus " + setting("protocol") + " short " + setting("write_protocol") +
           " mine.json)";
  return "copy its protocol's file";
}

void refuse_length(const Recording& recording, const sim::Protocol& protocol, std::optional<double> known_start_s) {
  const double start_s = known_start_s.value_or(0.0);
  const auto needed = static_cast<std::size_t>(protocol.samples());
  const double left_s = static_cast<double>(recording.signals.samples()) / recording.rate_hz - std::max(start_s, 0.0);
  const int cycles = protocol.experiment.cycles();
  const double first_s = std::max(-start_s, 0.0);  // of the protocol that was recorded, and its end
  const double last_s = std::min(first_s + left_s, protocol.duration_s());
  const int whole = whole_cycles(protocol.experiment, first_s, last_s);
  std::string problem = "recording has " + count_at(recording.signals.samples(), recording.rate_hz);
  if (start_s < 0.0) problem += ", which begin " + six_digits(-start_s) + " s after the protocol";
  if (start_s > 0.0) problem += ", " + six_digits(left_s) + " s of them after the start";
  problem +=
      "; the model's protocol '" + protocol.name + "' needs " + count_at(needed, protocol.experiment.sample_rate_hz);
  std::string remedy = "give whole trials of the protocol, or use your own model";
  if (in_memory(recording)) throw Error(Code::recording_too_short, where(recording), problem, remedy);
  const double missing_s = protocol.duration_s() - last_s, sample_s = 1.0 / recording.rate_hz;
  std::string lacking = first_s > sample_s ? "lacks the first " + milliseconds(first_s) + " s" : std::string();
  if (known_start_s && missing_s > sample_s)
    lacking += (lacking.empty() ? "lacks the last " : " and the last ") + milliseconds(missing_s) + " s";
  if (lacking.empty()) lacking = "is " + six_digits(protocol.duration_s() - left_s) + " s too short";
  if (whole >= 1 && whole < cycles) {
    problem += "; the recording " + lacking + ", and has only " + std::to_string(whole) + " of its " +
               std::to_string(cycles) + " whole cycles";
    const double unused_s = last_s - first_s - protocol.duration_s() + (cycles - whole) * protocol.experiment.cycle_s();
    if (unused_s > 1.0 / recording.rate_hz) problem += "; the other " + six_digits(unused_s) + " s would not be used";
    remedy = "give " + setting("rate") + " if the time column is wrong; or repeat the trial in full; or " +
             to_write(protocol) + ", set its cycles to " + std::to_string(whole) +
             ", give it a new name, and use it as " + setting("protocol") + " of a fit, or of a training with " +
             setting("stream") + " for your own model";
  } else if (known_start_s && whole == 0 && cycles > 1) {
    problem +=
        "; the recording " + lacking + ", and has none of the protocol's " + std::to_string(cycles) + " cycles whole";
    remedy = "repeat the trial in full, or give " + setting("rate") + " if the time column is wrong";
  } else {
    if (known_start_s) problem += "; the recording " + lacking;
    remedy = "fit it with its own " + setting("protocol") + ", or train a model for that protocol (" +
             setting("stream") + ") and give it as " + setting("model") + "; or give " + setting("rate") +
             " if the time column is wrong";
    // Minutes are the only unit of times that gives a plausible rate.
    const double in_minutes_s = 60.0 * static_cast<double>(recording.signals.samples()) / recording.rate_hz;
    if (std::abs(in_minutes_s - protocol.duration_s()) < 0.1 * protocol.duration_s())
      remedy = "if its times are in minutes, name their column time_min; else " + remedy;
  }
  throw Error(Code::recording_too_short, where(recording), problem, remedy);
}

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
    if (start_was_given || (before_s <= 0.5 * sample_s && after_s <= usual_excess_s * (1.0 + 1e-9))) {
      add_info(recording.warnings, "part_not_used", text);
    } else if (const std::optional<double> zero_s = zero_behind_start(recording, protocol)) {
      add_caution(recording.warnings, "starts_before_zero",
                  text + "; time 0 is " + milliseconds(*zero_s) +
                      " s after the first sample, and decid takes the first sample as the protocol's start: give " +
                      setting("begin") + " " + milliseconds(*zero_s) + " if the platform started at time 0, else " +
                      setting("begin") + " 0");
    } else {
      text += either(recording, "; another start selects other samples",
                     "; " + setting("begin") + " SECONDS selects other samples") +
              ". Check that the platform played this protocol.";
      add_caution(recording.warnings, "part_not_used", text);
    }
  }
  const long long lacking = place.first + (protocol.samples() - 1 - place.last);
  if (lacking > 0) {
    const bool is_usual = place.first == 0 && static_cast<double>(lacking) <= usual_excess_s * rate * (1.0 + 1e-9);
    const std::string text = "the recording lacks " + std::to_string(lacking) +
                             (lacking == 1 ? " sample" : " samples") + " of the protocol's " +
                             std::to_string(protocol.samples()) + " at its " +
                             (place.first == 0                       ? "end"
                              : place.last == protocol.samples() - 1 ? "start"
                                                                     : "ends") +
                             "; the mirror image of their neighbours replaces them";
    add_warning(recording.warnings, is_usual ? Severity::info : Severity::caution, "samples_lacking", text);
  }
}

}  // namespace decid::recording
