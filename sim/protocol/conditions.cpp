// Recording artefacts of trials: see conditions.hpp. Filters: bilinear transform of Butterworth filters, in
// second-order sections; Oppenheim and Schafer, Discrete-Time Signal Processing, chapter 7.
#include "sim/protocol/conditions.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "base/sample_range.hpp"
#include "sim/noise.hpp"
#include "sim/protocol/protocol.hpp"
#include "sim/streams.hpp"

namespace decid::sim {
namespace {

// Random numbers of a trial, all of streams::recording. Sizes come first, so that calibrations keep their trials.
constexpr std::uint64_t of_size = 0, of_presence = 16, of_sign = 32, of_kind = 48;
constexpr std::uint64_t of_places = 4096, of_noise = 1 << 20;

constexpr double stretch_s = 10.0;         // one gap in each
constexpr double shortest_memory_s = 1.0;  // of slow noise
constexpr double longest_memory_s = 30.0;
constexpr double knots_s = 0.1;  // slow noise is linear between

std::uint64_t number(Condition condition) {
  return static_cast<std::uint64_t>(condition);
}

/// Adds Ornstein-Uhlenbeck noise.
void add_slow_noise(std::span<double> sway, double stddev, const Random& random, double rate_hz) {
  const double memory_s = shortest_memory_s * decid::exp(random.uniform(of_kind + number(Condition::slow_noise)) *
                                                         decid::log(longest_memory_s / shortest_memory_s));
  const auto apart = static_cast<std::size_t>(std::max(1.0, std::floor(knots_s * rate_hz + 0.5)));
  const double kept = decid::exp(-static_cast<double>(apart) / rate_hz / memory_s);
  const double fresh = std::sqrt(1.0 - kept * kept) * stddev;
  std::vector<double> normals(sway.size() / apart + 2);
  random.fill_normal(normals, of_noise);
  double knot = stddev * normals[0];
  for (std::size_t first = 0, k = 1; first < sway.size(); first += apart, ++k) {
    const double next = kept * knot + fresh * normals[k], slope = (next - knot) / static_cast<double>(apart);
    const std::size_t end = std::min(sway.size(), first + apart);
    for (std::size_t i = first; i < end; ++i) sway[i] += knot + slope * static_cast<double>(i - first);
    knot = next;
  }
}

/// Returns one gap of `length` samples in each stretch, with at least one sample between gaps and at either end.
std::vector<SampleRange> draw_gaps(std::size_t samples, std::size_t length, const Random& random, Condition condition,
                                   double rate_hz) {
  const auto stretch = static_cast<std::size_t>(stretch_s * rate_hz);
  std::vector<SampleRange> gaps;
  for (std::size_t first = 1, k = 0; first + length < samples; first += stretch, ++k) {
    const std::size_t room = std::min(stretch, samples - 1 - first);
    if (room <= length) break;
    const std::uint64_t item = of_places * (1 + number(condition)) + k;
    const std::size_t place = first + static_cast<std::size_t>(random.below(item, room - length));
    gaps.push_back({place, place + length});
  }
  return gaps;
}

/// A section (b0 + b1 / z + b2 / z^2) / (1 + a1 / z + a2 / z^2) whose gain at 0 Hz is 1.
struct Section {
  double b0, b1, b2, a1, a2;

  /// Filters in place, as if the first value had lasted forever.
  void filter(std::span<double> x) const {
    double older = (b2 - a2) * x[0], newer = (b1 - a1) * x[0] + older;
    for (double& value : x) {
      const double out = b0 * value + newer;
      newer = b1 * value - a1 * out + older;
      older = b2 * value - a2 * out;
      value = out;
    }
  }
};

/// Returns a Butterworth low-pass of order 1, 2 or 4. `warped`: tan(pi cutoff / rate).
std::vector<Section> butterworth(int order, double warped) {
  if (order == 1) {
    const double scale = 1.0 / (1.0 + warped);
    return {{warped * scale, warped * scale, 0.0, (warped - 1.0) * scale, 0.0}};
  }
  // 1 / Q = 2 cos of the poles' angles: 45 degrees; 22.5 and 67.5.
  const std::vector<double> all = order == 2 ? std::vector<double>{1.41421356237309504880}
                                             : std::vector<double>{1.84775906502257351226, 0.76536686473017954346};
  std::vector<Section> sections;
  for (const double inverse_q : all) {
    const double square = warped * warped, scale = 1.0 / (1.0 + inverse_q * warped + square);
    sections.push_back({square * scale, 2.0 * square * scale, square * scale, 2.0 * (square - 1.0) * scale,
                        (1.0 - inverse_q * warped + square) * scale});
  }
  return sections;
}

void low_pass(std::span<double> sway, double cutoff_hz, const Random& random, double rate_hz) {
  const std::uint64_t kind = random.below(of_kind + number(Condition::low_pass), 6);
  constexpr int orders[] = {1, 2, 4};
  constexpr long long parts = 1LL << 40;
  // Half a turn is the sample rate.
  const double turns = std::min(0.5 * cutoff_hz / rate_hz, 0.24);
  const auto [sin, cos] = sincos_of_turn(static_cast<long long>(turns * static_cast<double>(parts)), parts);
  const std::vector<Section> sections = butterworth(orders[kind / 2], sin / cos);
  for (const Section& section : sections) section.filter(sway);
  if (kind % 2 == 0) return;
  std::ranges::reverse(sway);
  for (const Section& section : sections) section.filter(sway);
  std::ranges::reverse(sway);
}

/// Averages over `length` samples; over fewer at the ends.
void average(std::span<double> sway, std::size_t length, bool causal) {
  std::vector<double> sums(sway.size() + 1, 0.0);
  for (std::size_t i = 0; i < sway.size(); ++i) sums[i + 1] = sums[i] + sway[i];
  const std::size_t after = causal ? 1 : length - length / 2, before = length - after;
  for (std::size_t i = 0; i < sway.size(); ++i) {
    const std::size_t first = i > before ? i - before : 0, end = std::min(sway.size(), i + after);
    sway[i] = (sums[end] - sums[first]) / static_cast<double>(end - first);
  }
}

/// Extrapolates the parabola through three neighbouring values: `beyond` steps away from `first`, opposite to `second`.
double on_parabola(double first, double second, double third, double beyond) {
  const double step = first - second, bend = step - (second - third);
  return first + beyond * step + 0.5 * beyond * (beyond + 1.0) * bend;
}

}  // namespace

void begin_later(std::span<double> values, double samples, Before before) {
  const std::vector<double> was(values.begin(), values.end());
  const auto count = static_cast<long long>(was.size());
  const auto at = [&](long long i) {
    if (i >= 0 && i < count) return was[static_cast<std::size_t>(i)];
    if (before == Before::moving && i < 0) return on_parabola(was[0], was[1], was[2], static_cast<double>(-i));
    if (i < 0) return was.front();
    const auto last = was.rbegin();
    if (before == Before::moving) return on_parabola(last[0], last[1], last[2], static_cast<double>(i - count + 1));
    return last[0] + static_cast<double>(i - count + 1) * (last[0] - last[1]);
  };
  const double whole = std::floor(samples), t = samples - whole;
  const auto shift = static_cast<long long>(whole);
  const double weights[4] = {-t * (t - 1.0) * (t - 2.0) / 6.0, (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
                             -(t + 1.0) * t * (t - 2.0) / 2.0, (t + 1.0) * t * (t - 1.0) / 6.0};
  for (long long i = 0; i < count; ++i) {
    const long long j = i + shift;
    values[static_cast<std::size_t>(i)] =
        weights[0] * at(j - 1) + weights[1] * at(j) + weights[2] * at(j + 1) + weights[3] * at(j + 2);
  }
}

const ConditionInfo& info(Condition condition) {
  static constexpr std::array<ConditionInfo, condition_count> all{{{"start_s", 1.0, true},
                                                                   {"gain", 0.9, true},
                                                                   {"offset_deg", 45.0, true},
                                                                   {"drift_deg", 45.0, true},
                                                                   {"slow_noise_deg", 45.0, false},
                                                                   {"frozen_s", 5.0, false},
                                                                   {"lost_s", 5.0, false},
                                                                   {"average_s", 5.0, false},
                                                                   {"low_pass_hz", 500.0, false},
                                                                   {"quantisation_deg", 45.0, false}}};
  return all[static_cast<std::size_t>(condition)];
}

double drawn(const Conditions& conditions, Condition condition, std::uint64_t seed, std::uint64_t item) {
  const Severity& severity = conditions[condition];
  if (severity.fraction == 0.0) return 0.0;
  const Random random(seed, streams::recording, item);
  const std::uint64_t n = number(condition);
  if (random.uniform(of_presence + n) >= severity.fraction) return 0.0;
  if (severity.low > 0.0) {
    const double size =
        severity.low * decid::exp(random.uniform(of_size + n) * decid::log(severity.high / severity.low));
    return info(condition).has_sign && random.uniform(of_sign + n) < 0.5 ? -size : size;
  }
  return random.uniform(of_size + n, info(condition).has_sign ? -severity.high : 0.0, severity.high);
}

void record(const Protocol& protocol, std::uint64_t seed, std::uint64_t item, std::span<double> sway_rad) {
  const double rate_hz = protocol.experiment.sample_rate_hz;
  const Random random(seed, streams::recording, item);
  const auto size = [&](Condition condition) { return drawn(protocol.conditions, condition, seed, item); };
  const auto samples_in = [&](double seconds) {
    return std::min(static_cast<std::size_t>(std::floor(seconds * rate_hz + 0.5)), sway_rad.size() - 2);
  };
  const auto gaps = [&](Condition condition) {
    const std::size_t length = samples_in(size(condition));
    return length == 0 ? std::vector<SampleRange>{} : draw_gaps(sway_rad.size(), length, random, condition, rate_hz);
  };

  if (const double start_s = size(Condition::start); start_s != 0.0)
    begin_later(sway_rad, start_s * rate_hz,
                protocol.standing_s > 0.0 || protocol.moved_before ? Before::moving : Before::at_rest);
  if (const double gain = size(Condition::gain); gain != 0.0)
    for (double& value : sway_rad) value *= 1.0 + gain;
  if (const double offset = size(Condition::offset) * rad_per_deg; offset != 0.0)
    for (double& value : sway_rad) value += offset;
  if (const double drift = size(Condition::drift) * rad_per_deg; drift != 0.0)
    for (std::size_t i = 0; i < sway_rad.size(); ++i)
      sway_rad[i] += drift * static_cast<double>(i) / static_cast<double>(sway_rad.size() - 1);
  if (const double stddev = size(Condition::slow_noise) * rad_per_deg; stddev != 0.0)
    add_slow_noise(sway_rad, stddev, random, rate_hz);
  add_sensor_noise(protocol.noise.sensor, seed, item, sway_rad);
  for (const SampleRange& gap : gaps(Condition::frozen))
    for (std::size_t i = gap.first; i < gap.end; ++i) sway_rad[i] = sway_rad[gap.first - 1];
  for (const SampleRange& gap : gaps(Condition::lost)) bridge(sway_rad, gap);
  if (const std::size_t length = samples_in(size(Condition::average)); length > 1)
    average(sway_rad, length, random.uniform(of_kind + number(Condition::average)) < 0.5);
  if (const double cutoff_hz = size(Condition::low_pass); cutoff_hz > 0.0)
    low_pass(sway_rad, cutoff_hz, random, rate_hz);
  if (const double step = size(Condition::quantisation) * rad_per_deg; step > 0.0)
    for (double& value : sway_rad) value = std::floor(value / step + 0.5) * step;
}

}  // namespace decid::sim
