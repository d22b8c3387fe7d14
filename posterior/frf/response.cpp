// Mean frequency responses of controllers: see response.hpp.
#include "posterior/frf/response.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "posterior/density/density.hpp"
#include "posterior/density/elementary.hpp"
#include "posterior/frf/stability.hpp"
#include "sim/frf.hpp"
#include "sim/noise.hpp"
#include "sim/simulate.hpp"

namespace decid::frf {
namespace {

using posterior::quotient;
using sim::Complex;

constexpr int velocity_levels = 64;     // linear interpolation between them
constexpr double level_in_use = 1e-9;   // of the cycle's intervals
constexpr double each_harmonic = 1e12;  // bands per decade: no two harmonics fraction one
constexpr double min_stddev = 1e-12;

/// The steady cycle of the platform's velocity, by its harmonics.
class Cycle {
 public:
  explicit Cycle(const sim::Experiment& experiment) : cycle_s_(experiment.cycle_s()) {
    const sim::Stimulus stimulus = sim::make_stimulus(experiment);
    const sim::FrequencyResponse analysis(experiment, 0, each_harmonic);
    const std::vector<double> tilt_rad = sim::tilt_at_samples(experiment, stimulus);
    const std::vector<float> tilt(tilt_rad.begin(), tilt_rad.end());
    for (const sim::FrfPoint& point : analysis.measure(tilt, tilt))
      harmonics_.push_back(std::llround(point.frequency_hz * cycle_s_));

    if (harmonics_.empty())
      throw Error(Code::setting_out_of_range, "frequency response", "the stimulus does not move",
                  "use a protocol with a tilt");
    const double interval_s = stimulus.interval_steps * sim::integration_step_s;
    const auto first = std::llround(experiment.lead_in_s() / interval_s), count = std::llround(cycle_s_ / interval_s);
    for (long long j = 0; j < count; ++j) {
      rates_.push_back(stimulus.rate_rad_s[static_cast<std::size_t>(first + j)]);
      const auto [sin, cos] = sincos_of_turn(j, count);
      turns_.emplace_back(cos, -sin);
    }
  }

  double cycle_s() const { return cycle_s_; }
  double frequency_hz(std::size_t harmonic) const { return static_cast<double>(harmonics_[harmonic]) / cycle_s_; }
  std::size_t harmonics() const { return harmonics_.size(); }

  /// Returns the harmonic nearest to a frequency.
  std::size_t nearest(double frequency_hz) const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < harmonics_.size(); ++i)
      if (std::abs(this->frequency_hz(i) - frequency_hz) < std::abs(this->frequency_hz(best) - frequency_hz)) best = i;
    return best;
  }

  /// Returns levels from 0 to the highest speed.
  std::vector<double> levels_rad_s() const {
    double highest = 0.0;
    for (const double rate : rates_) highest = std::max(highest, std::abs(rate));
    std::vector<double> levels;
    for (int i = 0; i <= velocity_levels; ++i) levels.push_back(highest * i / velocity_levels);
    return levels;
  }

  /// Returns the coefficient of each level in the velocity's transform at a harmonic, for an odd function that is
  /// linear between the levels.
  std::vector<Complex> coefficients(std::size_t harmonic, const std::vector<double>& levels) const {
    std::vector<Complex> made(levels.size(), 0.0);
    const std::size_t count = rates_.size();
    const auto step = static_cast<std::size_t>(harmonics_[harmonic]) % count;
    for (std::size_t j = 0, place = 0; j < count; ++j, place = (place + step) % count) {
      if (rates_[j] == 0.0) continue;
      const auto [below, fraction] = between(std::abs(rates_[j]), levels);
      const Complex turn = rates_[j] < 0.0 ? -turns_[place] : turns_[place];
      made[below] += (1.0 - fraction) * turn;
      made[below + 1] += fraction * turn;
    }
    return made;
  }

  /// Returns the fraction of the cycle at each speed level; a speed between two levels counts for both.
  std::vector<double> fractions(const std::vector<double>& levels) const {
    std::vector<double> made(levels.size(), 0.0);
    for (const double rate : rates_) {
      const auto [below, fraction] = between(std::abs(rate), levels);
      made[below] += (1.0 - fraction) / static_cast<double>(rates_.size());
      made[below + 1] += fraction / static_cast<double>(rates_.size());
    }
    return made;
  }

 private:
  struct Between {
    std::size_t below;
    double fraction;  // of the level above
  };
  static Between between(double rate, const std::vector<double>& levels) {
    const double place = rate / levels.back() * velocity_levels;
    const auto below = std::min(static_cast<std::size_t>(place), levels.size() - 2);
    return {below, place - static_cast<double>(below)};
  }

  double cycle_s_;
  std::vector<long long> harmonics_;  // excited harmonics of the cycle
  std::vector<double> rates_;         // rad/s
  std::vector<Complex> turns_;        // exp(-2 pi i j / intervals)
};

/// Harmonics, first to last.
struct Neighbours {
  std::size_t first, last;
};

/// Returns the harmonics that a row averages or, without their number, the harmonics next to it.
Neighbours neighbours_of(const Cycle& cycle, const std::vector<double>& power, const Row& row,
                         const std::string& where) {
  const std::size_t nearest = cycle.nearest(row.frequency_hz);
  const double away_hz = std::abs(cycle.frequency_hz(nearest) - row.frequency_hz);
  if (away_hz > 1.001 / cycle.cycle_s())
    throw Error(Code::protocol_mismatch, where,
                format("the stimulus has no power at %g Hz; its nearest frequency is %.4g Hz", row.frequency_hz,
                       cycle.frequency_hz(nearest)),
                "give the played protocol with " + setting("protocol") + ", or leave such rows out");
  const auto count = static_cast<std::size_t>(row.harmonics);
  if (count > cycle.harmonics())
    throw Error(Code::protocol_mismatch, where,
                format("a row is the mean of %zu harmonics; the stimulus has %zu", count, cycle.harmonics()),
                "give the played protocol with " + setting("protocol"));
  if (count == 0) {
    const bool is_below = cycle.frequency_hz(nearest) < row.frequency_hz;
    const std::size_t other =
        is_below ? std::min(nearest + 1, cycle.harmonics() - 1) : std::max<std::size_t>(nearest, 1) - 1;
    const bool both = std::abs(cycle.frequency_hz(other) - row.frequency_hz) <= 1.001 / cycle.cycle_s();
    return both ? Neighbours{std::min(nearest, other), std::max(nearest, other)} : Neighbours{nearest, nearest};
  }
  Neighbours best{0, count - 1};
  double min_hz = std::numeric_limits<double>::infinity();
  for (std::size_t first = 0; first + count <= cycle.harmonics(); ++first) {
    double sum = 0.0, weighted = 0.0;
    for (std::size_t i = first; i < first + count; ++i) {
      sum += power[i];
      weighted += power[i] * cycle.frequency_hz(i);
    }
    const double off_hz = std::abs(weighted / sum - row.frequency_hz);
    if (off_hz < min_hz) {
      min_hz = off_hz;
      best = {first, first + count - 1};
    }
  }
  return best;
}

}  // namespace

double mean_passed(double signal, double stddev, double theta) {
  const double d = std::max(stddev, min_stddev);
  const auto g = [](double u) { return u * normal_distribution(u) + normal_density(u); };
  return d * (g((signal - theta) / d) - g((-signal - theta) / d));
}

ResponseModel::Line ResponseModel::line_at(double frequency_hz, double weight) const {
  const sim::Body& body = protocol_.experiment.body;
  const double step_s = sim::integration_step_s;
  const Complex z = posterior::turned(frequency_hz * step_s);
  const Complex forward = (z - 1.0) / step_s, backward = quotient(forward, z);
  const sim::Family& family = protocol_.family();
  return {frequency_hz,
          weight,
          forward,
          backward,
          body.inertia_kgm2 * forward * backward - body.mgh(),
          quotient(1.0, forward + 1.0 / family.slow_time_s),
          quotient(1.0, body.mgh() * z * (forward + 1.0 / family.torque_time_s))};
}

ResponseModel::ResponseModel(const sim::Protocol& protocol, const Table& table)
    : protocol_(posterior::require_family(protocol)), noise_rad_s_(sim::noise_velocity_stddev(protocol)) {
  const Cycle cycle(protocol.experiment);
  const std::vector<double> levels = cycle.levels_rad_s();
  const std::vector<double> fractions = cycle.fractions(levels);
  const auto used = [&](std::size_t l) { return l > 0 && fractions[l] > level_in_use; };
  std::vector<std::vector<Complex>> coefficients;
  std::vector<Complex> platform;
  std::vector<double> power;  // of the tilt
  for (std::size_t i = 0; i < cycle.harmonics(); ++i) {
    coefficients.push_back(cycle.coefficients(i, levels));
    Complex sum = 0.0;
    for (std::size_t l = 0; l < levels.size(); ++l) sum += levels[l] * coefficients.back()[l];
    platform.push_back(sum);
    power.push_back(std::norm(quotient(sum, line_at(cycle.frequency_hz(i), 1.0).forward)));
  }
  for (std::size_t l = 0; l < levels.size(); ++l)
    if (used(l)) levels_.push_back({levels[l], fractions[l]});
  for (const Row& row : table.rows) {
    const auto [first, last] = neighbours_of(cycle, power, row, table.file);
    Band band;
    double sum = 0.0;
    for (std::size_t i = first; i <= last; ++i) sum += power[i];
    for (std::size_t l = 0; l < levels.size(); ++l) {
      Complex passing = 0.0;
      for (std::size_t i = first; i <= last; ++i) passing += power[i] / sum * quotient(coefficients[i][l], platform[i]);
      if (used(l)) band.passing.push_back(passing);
    }
    if (row.harmonics == 0) band.lines.push_back(line_at(row.frequency_hz, 1.0));
    for (std::size_t i = first; i <= last && row.harmonics > 0; ++i)
      band.lines.push_back(line_at(cycle.frequency_hz(i), power[i] / sum));
    bands_.push_back(std::move(band));
  }
}

void ResponseModel::respond(const sim::Parameters& p, std::span<Complex> responses, std::span<Complex> derived) const {
  if (responses.size() != bands_.size() || (!derived.empty() && derived.size() != bands_.size() * derivatives))
    throw Error(Code::size_mismatch, "frequency response",
                format("got space for %zu responses and %zu derivatives", responses.size(), derived.size()),
                format("give space for %zu, and for none or %zu", bands_.size(), bands_.size() * derivatives));
  using enum sim::Coefficient;
  const sim::Family& family = protocol_.family();
  const sim::Coefficients c = family.coefficients(p);
  const bool has_feedback = !family.has_unit_gains();
  const double reach = c[position] + c[gravity];
  std::array<double, velocity_levels> passed;
  for (std::size_t l = 0; l < levels_.size(); ++l)
    passed[l] = mean_passed(levels_[l].rate_rad_s, c[nv] * noise_rad_s_, c[theta]);
  std::fill(responses.begin(), responses.end(), 0.0);
  std::fill(derived.begin(), derived.end(), 0.0);
  for (std::size_t row = 0; row < bands_.size(); ++row) {
    Complex lost = c[position];
    for (std::size_t l = 0; l < levels_.size(); ++l) lost -= c[tilt] * passed[l] * bands_[row].passing[l];
    for (const Line& line : bands_[row].lines) {
      const Complex delayed = posterior::turned(-line.frequency_hz * c[delay]);
      const Complex servo = c[kp] + c[kd] * line.forward;
      Complex loop = delayed, torque_loop = 0.0, slow_loop = 0.0;
      if (has_feedback) {
        torque_loop = c[torque] * line.torque;
        slow_loop = c[slow] * line.slow;
        loop = quotient(delayed, 1.0 - delayed * servo * torque_loop);
      }
      const Complex active = loop * servo;
      Complex returned = reach * loop * (c[kp] + c[kd] * line.backward);
      if (has_feedback) returned += active * slow_loop;
      const Complex inverse = quotient(line.weight, line.body + c[kp_pass] + c[kd_pass] * line.backward + returned);
      const Complex drive = c[kp_pass] + c[kd_pass] * line.forward + active * lost;
      const Complex response = drive * inverse;  // times the weight
      responses[row] += response;
      if (derived.empty()) continue;
      const Complex back = response / line.weight;
      const std::span<Complex> here = derived.subspan(row * derivatives, derivatives);
      const auto add = [&](sim::Coefficient by, Complex value) {
        here[static_cast<std::size_t>(by)] += value * inverse;
      };
      const Complex by_loop = active * lost - returned * back;  // times K
      add(kp, loop * (lost - reach * back));
      add(kd, loop * (line.forward * lost - reach * line.backward * back));
      add(kp_pass, 1.0 - back);
      add(kd_pass, line.forward - line.backward * back);
      here[by_passed] -= c[tilt] * active * inverse;
      const Complex by_delay = Complex(0.0, -2.0 * sim::pi * line.frequency_hz) * by_loop;
      if (!has_feedback) {
        add(delay, by_delay);
        continue;
      }
      const Complex by_servo = loop * (torque_loop * by_loop - slow_loop * back);
      add(kp, by_servo);
      add(kd, by_servo * line.forward);
      add(delay, by_delay * quotient(loop, delayed));
      const Complex by_gravity = -loop * (c[kp] + c[kd] * line.backward) * back;
      add(gravity, by_gravity);
      add(position, active + by_gravity);
      // lost = position - tilt g; g is the row's
      Complex gain = 0.0;
      for (std::size_t l = 0; l < levels_.size(); ++l) gain += passed[l] * bands_[row].passing[l];
      add(tilt, -active * gain);
      add(slow, -active * line.slow * back);
      add(torque, active * line.torque * by_loop);
    }
  }
}

double ResponseModel::passing_gain(double nv, double theta) const {
  double passed = 0.0, all = 0.0;
  for (const Level& level : levels_) {
    const double weight = level.fraction * level.rate_rad_s;
    passed += weight * mean_passed(level.rate_rad_s, nv * noise_rad_s_, theta);
    all += weight * level.rate_rad_s;
  }
  return passed / all;
}

ResponseModel::PassingSlopes ResponseModel::passing_slopes(double nv, double theta) const {
  PassingSlopes slopes{0.0, 0.0};
  double all = 0.0;
  const double d = std::max(nv * noise_rad_s_, min_stddev);
  for (const Level& level : levels_) {
    const double weight = level.fraction * level.rate_rad_s;
    const double above = (level.rate_rad_s - theta) / d, below = (-level.rate_rad_s - theta) / d;
    slopes.by_nv += weight * noise_rad_s_ * (normal_density(above) - normal_density(below));
    slopes.by_theta -= weight * (normal_distribution(above) - normal_distribution(below));
    all += weight * level.rate_rad_s;
  }
  return {slopes.by_nv / all, slopes.by_theta / all};
}

bool ResponseModel::is_stable(const sim::Parameters& p) const {
  return frf::is_stable(protocol_.experiment.body, protocol_.family(), protocol_.family().coefficients(p));
}

}  // namespace decid::frf
