// Kinds of stimulus: their bounds, lengths and tilt; see stimulus.hpp. A new kind needs an overload in each family of
// functions below. All times are whole milliseconds; doubles appear only at the end.
#include "sim/protocol/stimulus.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <string>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "sim/protocol/detail/checker.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::sim {
namespace {

constexpr double max_tilt_deg = 45.0;
constexpr int max_cycles = 100'000;
constexpr std::size_t max_samples = 1'000'000, max_components = 100, max_moves = 10'000;
/// Linear interpolation between samples follows a sine of this many samples per period to 3%.
constexpr int min_samples_per_period = 10;
/// Bounds of broken_joint.
constexpr double max_joint_steps = 5.0, min_joint_deg = 0.01;

// ---- bounds: check_kind(check, kind, steps_per_sample)

template <class Kind>
void check_common(const Checker& check, const std::string& prefix, const Kind& kind) {
  check.within(prefix + "cycles", kind.cycles, 1, max_cycles);
  check.within(prefix + "lead_in_s", kind.lead_in_s, 0.0, longest_trial_s);
  check.whole_milliseconds(prefix + "lead_in_s", kind.lead_in_s);
  check.within(prefix + "lead_out_s", kind.lead_out_s, 0.0, longest_trial_s);
  check.whole_milliseconds(prefix + "lead_out_s", kind.lead_out_s);
}

/// Returns the sample rate in Hz of a number of steps per sample.
double rate_of(int steps_per_sample) {
  return static_cast<double>(steps_per_second) / steps_per_sample;
}

template <class Kind>
void check_sampled(const Checker& check, const std::string& prefix, const Kind& kind, int steps_per_sample) {
  check_common(check, prefix, kind);
  check.whole_samples(prefix + "lead_in_s", kind.lead_in_s, rate_of(steps_per_sample));
  check.whole_samples(prefix + "lead_out_s", kind.lead_out_s, rate_of(steps_per_sample));
}

template <class Kind>
void check_given_cycle(const Checker& check, const std::string& prefix, const Kind& kind, int steps_per_sample) {
  check.positive(prefix + "cycle_s", kind.cycle_s, longest_trial_s);
  check.whole_milliseconds(prefix + "cycle_s", kind.cycle_s);
  check.whole_samples(prefix + "cycle_s", kind.cycle_s, rate_of(steps_per_sample));
}

void check_count(const Checker& check, const std::string& setting, std::size_t count, std::size_t min_count,
                 std::size_t max_count) {
  if (count >= min_count && count <= max_count) return;
  check.fail(setting, "has " + std::to_string(count) + " entries",
             "give " + std::to_string(min_count) + " to " + std::to_string(max_count));
}

void check_kind(const Checker& check, const Sequence& sequence, int) {
  for (const int coefficient : sequence.feedback) check.within("sequence feedback", coefficient, -2, 2);
  for (const int value : sequence.start) check.within("sequence start", value, 0, 2);
  if (std::ranges::all_of(sequence.start, [](int value) { return value == 0; })) {
    check.fail("sequence start", "is all zero", "set at least one stage to 1 or 2");
  }
  check.positive("sequence state_s", sequence.state_s, longest_trial_s);
  check.within("sequence state_s", sequence.state_s, 1e-3, longest_trial_s);
  check.whole_milliseconds("sequence state_s", sequence.state_s);
  check.positive("sequence amplitude_deg", sequence.amplitude_deg, max_tilt_deg);
  check_common(check, "sequence ", sequence);

  std::vector<int> values;
  try {
    values = ternary_sequence(sequence);
  } catch (const Error& error) {
    check.fail("sequence", error.problem(), error.remedy());
  }
  const int sum = std::accumulate(values.begin(), values.end(), 0);
  if (sum != 0) {
    check.fail("sequence feedback", "makes a sequence that sums to " + std::to_string(sum),
               "use a primitive feedback; the platform would not return at the end of a cycle");
  }
  const double cycle_s = static_cast<double>(values.size()) * sequence.state_s;
  if (!(sequence.offset_s >= 0.0 && sequence.offset_s < cycle_s)) {
    check.fail("sequence offset_s", "is " + given_text(sequence.offset_s),
               "give a value from 0 to below the cycle's " + setting_text(cycle_s));
  }
  check.whole_milliseconds("sequence offset_s", sequence.offset_s);
}

void check_kind(const Checker& check, const MeasuredTilt& measured, int steps_per_sample) {
  check_count(check, "measured tilt_deg", measured.tilt_deg.size(), 2, max_samples);
  for (std::size_t k = 0; k < measured.tilt_deg.size(); ++k) {
    const double tilt = measured.tilt_deg[k] - measured.tilt_deg.front();
    if (std::abs(tilt) <= max_tilt_deg) continue;  // false for NaN
    check.fail("measured tilt_deg", "sample " + std::to_string(k) + " is " + setting_text(tilt) + " from the first",
               "stay within 45 degrees of it, and check the unit");
  }
  check_sampled(check, "measured ", measured, steps_per_sample);
}

void check_kind(const Checker& check, const Sines& sines, int steps_per_sample) {
  check_count(check, "sines components", sines.components.size(), 1, max_components);
  check_sampled(check, "sines ", sines, steps_per_sample);
  check_given_cycle(check, "sines ", sines, steps_per_sample);
  const double highest_hz = static_cast<double>(steps_per_second) / (steps_per_sample * min_samples_per_period);
  double sum = 0.0;
  for (std::size_t i = 0; i < sines.components.size(); ++i) {
    const Sine& sine = sines.components[i];
    const std::string prefix = "sines components[" + std::to_string(i) + "] ";
    check.positive(prefix + "frequency_hz", sine.frequency_hz, highest_hz);
    check.positive(prefix + "amplitude_deg", sine.amplitude_deg, max_tilt_deg);
    check.within(prefix + "phase_deg", sine.phase_deg, -360.0, 360.0);
    sum += sine.amplitude_deg;
    const double periods = sine.frequency_hz * sines.cycle_s;
    if (sines.cycles > 1 && !(std::abs(periods - std::floor(periods + 0.5)) <= 1e-6)) {
      check.fail(prefix + "frequency_hz",
                 "makes " + setting_text(periods) + " periods in a cycle, so cycles do not join",
                 "give a multiple of 1 / cycle_s, or cycles 1");
    }
  }
  if (sum > max_tilt_deg) {
    check.fail("sines components", "have amplitudes that add up to " + setting_text(sum) + " degrees",
               "stay within 45 degrees");
  }
}

void check_kind(const Checker& check, const RaisedCosines& cosines, int steps_per_sample) {
  check_count(check, "raised_cosines moves", cosines.moves.size(), 1, max_moves);
  check_sampled(check, "raised_cosines ", cosines, steps_per_sample);
  check_given_cycle(check, "raised_cosines ", cosines, steps_per_sample);
  const double min_move_s = static_cast<double>(steps_per_sample * min_samples_per_period) / steps_per_second;
  double level = 0.0;
  int end = 0;  // of the previous move, ms
  for (std::size_t i = 0; i < cosines.moves.size(); ++i) {
    const Move& move = cosines.moves[i];
    const std::string prefix = "raised_cosines moves[" + std::to_string(i) + "] ";
    check.within(prefix + "start_s", move.start_s, 0.0, longest_trial_s);
    check.whole_milliseconds(prefix + "start_s", move.start_s);
    check.within(prefix + "duration_s", move.duration_s, min_move_s, longest_trial_s);
    check.whole_milliseconds(prefix + "duration_s", move.duration_s);
    check.within(prefix + "amplitude_deg", move.amplitude_deg, -max_tilt_deg, max_tilt_deg);
    if (move.amplitude_deg == 0.0) check.fail(prefix + "amplitude_deg", "is 0", "leave the move out");
    if (milliseconds(move.start_s) < end) {
      check.fail(prefix + "start_s", "is " + given_text(move.start_s) + ", before the previous move ends",
                 "give moves in time order, without overlap");
    }
    end = milliseconds(move.start_s) + milliseconds(move.duration_s);
    if (end > milliseconds(cosines.cycle_s)) {
      check.fail(prefix + "duration_s", "ends the move after the cycle's " + setting_text(cosines.cycle_s) + " s",
                 "end every move within cycle_s");
    }
    const double farthest = level + move.amplitude_deg;
    if (std::abs(farthest) > max_tilt_deg) {
      check.fail(prefix + "amplitude_deg", "takes the platform to " + setting_text(farthest) + " degrees",
                 "stay within 45 degrees");
    }
    if (move.shape == Move::Shape::step) level = farthest;
  }
  if (cosines.cycles > 1 && std::abs(level) > 1e-9) {
    check.fail("raised_cosines moves", "end a cycle at " + setting_text(level) + " degrees, so cycles do not join",
               "give steps that add up to 0, or give cycles 1");
  }
}

// ---- lengths: cycle_of(kind, steps_per_sample), in ms

long long cycle_of(const Sequence& sequence, int) {
  return static_cast<long long>(ternary_sequence(sequence).size()) * milliseconds(sequence.state_s);
}

long long cycle_of(const MeasuredTilt& measured, int steps_per_sample) {
  return static_cast<long long>(measured.tilt_deg.size()) * steps_per_sample;
}

long long cycle_of(const Sines& sines, int) {
  return milliseconds(sines.cycle_s);
}

long long cycle_of(const RaisedCosines& cosines, int) {
  return milliseconds(cosines.cycle_s);
}

// ---- one cycle of the sampled kinds: cycle_deg(kind, steps_per_sample), samples and the end, the first value 0

std::vector<double> cycle_deg(const MeasuredTilt& measured, int) {
  std::vector<double> tilt;
  tilt.reserve(measured.tilt_deg.size() + 1);
  for (const double value : measured.tilt_deg) tilt.push_back(value - measured.tilt_deg.front());
  tilt.push_back(tilt.back());
  return tilt;
}

std::vector<double> cycle_deg(const Sines& sines, int steps_per_sample) {
  std::vector<double> tilt(static_cast<std::size_t>(milliseconds(sines.cycle_s) / steps_per_sample) + 1, 0.0);
  const double rate_hz = rate_of(steps_per_sample);
  for (const Sine& sine : sines.components) {
    const double phase = sine.phase_deg / 360.0, first = sincos_of_turns(phase).sin;
    for (std::size_t k = 0; k < tilt.size(); ++k) {
      const double turns = sine.frequency_hz * (static_cast<double>(k) / rate_hz) + phase;
      tilt[k] += sine.amplitude_deg * (sincos_of_turns(turns).sin - first);
    }
  }
  return tilt;
}

std::vector<double> cycle_deg(const RaisedCosines& cosines, int steps_per_sample) {
  std::vector<double> tilt(static_cast<std::size_t>(milliseconds(cosines.cycle_s) / steps_per_sample) + 1);
  double level = 0.0;
  std::size_t k = 0;
  const auto now = [&] { return static_cast<int>(k) * steps_per_sample; };
  for (const Move& move : cosines.moves) {
    const int start = milliseconds(move.start_s), duration = milliseconds(move.duration_s);
    const bool stays = move.shape == Move::Shape::step;
    for (; k < tilt.size() && now() < start; ++k) tilt[k] = level;
    for (; k < tilt.size() && now() < start + duration; ++k) {
      const double cos = sincos_of_turn(now() - start, stays ? 2LL * duration : duration).cos;
      tilt[k] = level + 0.5 * move.amplitude_deg * (1.0 - cos);
    }
    if (stays) level += move.amplitude_deg;
  }
  for (; k < tilt.size(); ++k) tilt[k] = level;
  return tilt;
}

// ---- the tilt of a trial: play(kind, experiment)

// Returns the highest minus lowest accumulated value of a sequence that sums to zero.
int peak_to_peak(const std::vector<int>& values) {
  int sum = 0, lowest = 0, highest = 0;
  for (const int value : values) {
    sum += value;
    lowest = std::min(lowest, sum);
    highest = std::max(highest, sum);
  }
  return highest - lowest;
}

Stimulus play(const Sequence& sequence, const Experiment& experiment) {
  const std::vector<int> values = ternary_sequence(sequence);
  const int state_ms = milliseconds(sequence.state_s);
  const int cycle_ms = static_cast<int>(values.size()) * state_ms;
  const int first_ms = milliseconds(sequence.lead_in_s);
  const int last_ms = first_ms + sequence.cycles * cycle_ms;
  const int offset_ms = milliseconds(sequence.offset_s);
  const double rad_per_count = sequence.amplitude_deg * rad_per_deg / (peak_to_peak(values) * state_ms);

  Stimulus stimulus;
  // The widest grid with a point at every change of the velocity and at every sample.
  stimulus.interval_steps = std::gcd(std::gcd(experiment.steps_per_sample(), state_ms), std::gcd(first_ms, offset_ms));
  const int interval = stimulus.interval_steps;
  int count = 0;  // state values, summed over the milliseconds
  const int steps = experiment.steps();
  for (int k = 0; k < steps; k += interval) {
    const bool moving = k >= first_ms && k < last_ms;
    const int state = (offset_ms + (k - first_ms)) % cycle_ms / state_ms;
    const int value = moving ? values[static_cast<std::size_t>(state)] : 0;
    stimulus.tilt_rad.push_back(count * rad_per_count);
    stimulus.rate_rad_s.push_back(value * (rad_per_count * steps_per_second));
    count += value * interval;
  }
  stimulus.tilt_rad.push_back(count * rad_per_count);
  return stimulus;
}

// Plays any kind that has a cycle_deg.
template <class Kind>
Stimulus play(const Kind& kind, const Experiment& experiment) {
  const int steps_per_sample = experiment.steps_per_sample();
  const std::vector<double> cycle = cycle_deg(kind, steps_per_sample);
  Stimulus stimulus;
  stimulus.interval_steps = steps_per_sample;
  std::vector<double>& tilt = stimulus.tilt_rad;
  tilt.reserve(static_cast<std::size_t>(experiment.samples()) + 1);
  tilt.assign(static_cast<std::size_t>(milliseconds(kind.lead_in_s) / steps_per_sample), 0.0);
  for (int i = 0; i < kind.cycles; ++i) tilt.insert(tilt.end(), cycle.begin(), cycle.end() - 1);
  tilt.resize(static_cast<std::size_t>(experiment.samples()) + 1, cycle.back());
  for (double& value : tilt) value *= rad_per_deg;
  stimulus.rate_rad_s.reserve(tilt.size() - 1);
  for (std::size_t k = 0; k + 1 < tilt.size(); ++k) {
    stimulus.rate_rad_s.push_back((tilt[k + 1] - tilt[k]) * experiment.sample_rate_hz);
  }
  return stimulus;
}

}  // namespace

void check_stimulus(const Checker& check, const Experiment& experiment) {
  const int steps_per_sample = experiment.steps_per_sample();
  std::visit(
      [&](const auto& kind) {
        check_kind(check, kind, steps_per_sample);
        const double cycle_s = static_cast<double>(cycle_of(kind, steps_per_sample)) / steps_per_second;
        const double length_s = kind.lead_in_s + kind.cycles * cycle_s + kind.lead_out_s;
        if (length_s <= longest_trial_s) return;
        check.fail("the trial", "lasts " + setting_text(length_s) + " s",
                   "shorten it to at most 3600 s: fewer or shorter cycles");
      },
      experiment.stimulus);
}

long long cycle_steps(const StimulusKind& kind, int steps_per_sample) {
  return std::visit([=](const auto& k) { return cycle_of(k, steps_per_sample); }, kind);
}

std::vector<int> ternary_sequence(const Sequence& sequence) {
  const std::size_t stages = sequence.feedback.size();
  if (stages < 2 || stages > 12 || sequence.start.size() != stages) {
    throw Error(Code::setting_out_of_range, "sequence",
                "feedback has " + std::to_string(stages) + " stages, start " + std::to_string(sequence.start.size()),
                "give both the same number of stages, 2 to 12");
  }
  std::size_t longest = 1;  // the number of possible register contents
  for (std::size_t stage = 0; stage < stages; ++stage) longest *= 3;
  std::vector<int> reg = sequence.start;
  std::vector<int> values;
  do {
    int sum = 0;
    for (std::size_t stage = 0; stage < stages; ++stage) sum += sequence.feedback[stage] * reg[stage];
    const int value = (sum % 3 + 3) % 3;
    std::shift_right(reg.begin(), reg.end(), 1);
    reg.front() = value;
    values.push_back(value == 2 ? -1 : value);
    if (values.size() > longest) {
      throw Error(Code::setting_out_of_range, "sequence", "the register never returns to its start",
                  "give feedback a last coefficient of 1, 2, -1 or -2");
    }
  } while (reg != sequence.start);
  return values;
}

std::string broken_joint(const std::vector<double>& tilt_deg) {
  if (tilt_deg.empty()) return {};
  double max_step = 0.0;
  for (std::size_t k = 1; k < tilt_deg.size(); ++k) {
    max_step = std::max(max_step, std::abs(tilt_deg[k] - tilt_deg[k - 1]));
  }
  const double joint = std::abs(tilt_deg.front() - tilt_deg.back());
  if (joint <= std::max(max_joint_steps * max_step, min_joint_deg)) return {};
  return "jumps by " + setting_text(joint) + " degrees from its last sample to the next cycle's first; " +
         "within a cycle by at most " + setting_text(max_step);
}

double Stimulus::tilt_at(int step) const {
  const int point = step / interval_steps, beyond = step % interval_steps;
  const auto k = static_cast<std::size_t>(point);
  return beyond == 0 ? tilt_rad[k] : tilt_rad[k] + beyond * (rate_rad_s[k] / steps_per_second);
}

double Stimulus::peak_to_peak_rad() const {
  const auto [low, high] = std::ranges::minmax(tilt_rad);
  return high - low;
}

Stimulus make_stimulus(const Experiment& experiment) {
  return std::visit([&](const auto& kind) { return play(kind, experiment); }, experiment.stimulus);
}

}  // namespace decid::sim
