// A trial: see simulate.hpp for the equations and the choices made where the paper is silent.
// Here trials are led through the lanes; the steps themselves are kernels (kernels/generic_pendulums.hpp).
#include "sim/simulate.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/math.hpp"
#include "base/parallel.hpp"
#include "sim/kernels/kernels.hpp"

namespace decid::sim {
namespace {

constexpr double step_s = 1.0 / steps_per_second;

// (sin a - a) / a^3 for |a| <= 5 degrees as a polynomial in a^2: the best one of its degree for the relative error of
// the sine, 8.5e-17 (Remez exchange in 50 digits). Rounding adds at most half a unit in the last place of a; beyond the
// bound, where a trial is over, the error grows slowly.
constexpr double sine_coefficients[] = {-0.16666666666644338547, 0.0083333331554029862068, -0.00019837239079875674672};

// A delay as a number of steps: whole ones, the fraction beyond, and the first step that is not before it.
struct Lag {
  explicit Lag(double delay_s) {
    double steps = delay_s * steps_per_second;
    // A delay of whole milliseconds is one, whatever the rounding of its product.
    const double nearest = std::floor(steps + 0.5);
    if (std::abs(steps - nearest) < 1e-9) steps = nearest;
    whole = static_cast<int>(steps);
    fraction = steps - whole;
    first_step = static_cast<int>(std::ceil(steps));
  }
  int whole, first_step;
  double fraction;
};
static_assert(longest_delay_s * steps_per_second <= Pendulums::longest_lag);

void check_parameters(const Parameters& parameters) {
  for (std::size_t i = 0; i < parameter_count; ++i) {
    const double value = parameters[i];
    const double largest = i == Delay ? longest_delay_s : std::numeric_limits<double>::max();
    if (value >= 0.0 && value <= largest) continue;  // false for NaN
    throw Error(std::string("parameter ") + parameter_info[i].name, "is " + std::to_string(value),
                i == Delay ? "give a delay from 0 to " + std::to_string(longest_delay_s) + " s"
                           : "give a finite value, 0 or above");
  }
}

Protocol checked(Protocol protocol) {
  protocol.validate();
  return protocol;
}

/// The experiment as the kernels need it.
struct Setting {
  const Protocol& protocol;
  const VestibularNoiseMaker& noise_maker;
  const std::vector<double>& tilt_and_rate;
  int samples;
  Isa isa;
};

/// One thread's lanes and the trials in them.
class Lanes {
 public:
  explicit Lanes(const Setting& setting)
      : setting_(setting),
        advance_(simulator_kernels(setting.isa).advance_pendulums),
        samples_(static_cast<std::size_t>(setting.samples)),
        step_over_inertia_(step_s / setting.protocol.body.inertia_kgm2),
        lanes_(std::make_unique<Pendulums>()),
        silence_((samples_ + 1) * fft_lanes, 0.0),
        sways_(std::make_unique_for_overwrite<double[]>((Pendulums::count + 1) * samples_)) {
    const double mgh = setting.protocol.body.mgh();
    course_.step_s = step_s;
    for (std::size_t i = 0; i < std::size(sine_coefficients); ++i) {
      course_.sine[i] = step_over_inertia_ * mgh * sine_coefficients[i];
    }
    course_.steps_per_sample = setting.protocol.steps_per_sample();
    course_.per_step = 1.0 / course_.steps_per_sample;
    intervals_ = setting.tilt_and_rate.size() / 2 / samples_;
    course_.interval_steps = course_.steps_per_sample / static_cast<int>(intervals_);
    course_.sway_limit_rad = sway_limit_rad;
    lanes_->row = Pendulums::longest_lag;
    for (int lane = 0; lane < Pendulums::count; ++lane) rest(lane);
  }

  /// Runs the trials that `next` names, until it returns a negative index and all lanes are free.
  template <class Next>
  void run(const Next& next, const Simulator::TrialOf& trial_of, const Simulator::Finished& finished) {
    for (;;) {
      int busy = 0, samples = setting_.samples;
      for (int lane = 0; lane < Pendulums::count; ++lane) {
        Work& work = works_[static_cast<std::size_t>(lane)];
        if (work.index < 0) {
          if (waiting_.empty()) prepare(next, trial_of);
          if (!waiting_.empty()) {
            begin(lane, waiting_.back());
            waiting_.pop_back();
          }
        }
        busy += work.index >= 0 ? 1 : 0;
        samples = std::min(samples, work.samples_left);
      }
      if (busy == 0) return;
      advance(samples);
      for (int lane = 0; lane < Pendulums::count; ++lane) end_if_over(lane, finished);
    }
  }

 private:
  /// The noises of fft_lanes trials, side by side, and how many of those are not over.
  struct Noise {
    std::vector<double> rate;
    int users = 0;
  };
  struct Prepared {
    int index;
    Parameters parameters;
    Noise* noise;  // null: none
    const double* noise_rate;
  };
  /// The trial in a lane.
  struct Work {
    int index = -1;  // negative: none
    int samples_left = 0;
    int lag = 0;
    Noise* noise = nullptr;
  };

  double* sway_of(int lane) { return sways_.get() + static_cast<std::size_t>(lane) * samples_; }

  /// The next trials, as many as have their noise made at once; none when `next` has no more.
  template <class Next>
  void prepare(const Next& next, const Simulator::TrialOf& trial_of) {
    constexpr std::size_t most = fft_lanes;
    std::vector<double> nv;
    std::vector<Random> random;
    Noise* noise = nullptr;
    while (waiting_.size() < most) {
      const int index = next();
      if (index < 0) break;
      const std::size_t column = waiting_.size();
      const Trial trial = trial_of(index);
      check_parameters(trial.parameters);
      waiting_.push_back({index, trial.parameters, nullptr, silence_.data()});
      nv.push_back(trial.parameters[Nv]);
      random.push_back(trial.noise);
      if (trial.parameters[Nv] == 0.0) continue;
      if (noise == nullptr) noise = free_noise();
      ++noise->users;
      waiting_.back().noise = noise;
      waiting_.back().noise_rate = noise->rate.data() + column;
    }
    if (noise != nullptr) setting_.noise_maker.velocity_lanes(nv, random, noise->rate, setting_.isa);
    std::reverse(waiting_.begin(), waiting_.end());  // they are taken from its end
  }

  Noise* free_noise() {
    for (const auto& noise : noises_) {
      if (noise->users == 0) return noise.get();
    }
    noises_.push_back(std::make_unique<Noise>());
    noises_.back()->rate.resize((samples_ + 1) * fft_lanes);
    return noises_.back().get();
  }

  /// Nothing to do: a lane that stays at zero.
  void rest(int lane) {
    place(lane, {-1, Parameters{}, nullptr, silence_.data()}, sways_.get() + Pendulums::count * samples_);
    lanes_->k1[lane] = lanes_->k2[lane] = 0.0;
  }

  void begin(int lane, const Prepared& trial) { place(lane, trial, sway_of(lane)); }

  void place(int lane, const Prepared& trial, double* sway) {
    Pendulums& p = *lanes_;
    const Parameters& parameters = trial.parameters;
    const double c = step_over_inertia_;
    p.kp[lane] = 2.0 * c * parameters[Kp];
    p.kd[lane] = 2.0 * c * parameters[Kd];
    p.passive[lane] = c * parameters[Kp_pass];
    p.damping[lane] = c * parameters[Kd_pass];
    p.k1[lane] = c * (setting_.protocol.body.mgh() - parameters[Kp_pass]);
    p.k2[lane] = 1.0 - p.damping[lane];
    p.theta[lane] = 0.5 * parameters[Theta];
    p.minus_theta[lane] = -p.theta[lane];
    const Lag lag(parameters[Delay]);
    p.fraction[lane] = lag.fraction;
    for (double* state : {p.sway, p.sway_rate, p.error, p.newer, p.largest}) state[lane] = 0.0;
    p.noise[lane] = 0.5 * trial.noise_rate[0];
    p.noise_rate[lane] = trial.noise_rate;
    p.stimulus[lane] = setting_.tilt_and_rate.data();
    p.samples[lane] = sway;
    p.delayed[lane] = p.commands + lane - static_cast<std::ptrdiff_t>(lag.whole) * Pendulums::count;
    p.first_row[lane] = p.row + lag.first_step;
    p.last_first_row = std::max(p.last_first_row, p.row + lag.first_step);
    works_[static_cast<std::size_t>(lane)] = {trial.index, setting_.samples, lag.whole, trial.noise};
  }

  void advance(int samples) {
    Pendulums& p = *lanes_;
    if (p.row + course_.steps_per_sample > Pendulums::rows) move_commands_back();
    const int done = advance_(p, course_, std::min(samples, (Pendulums::rows - p.row) / course_.steps_per_sample));
    p.row += done * course_.steps_per_sample;
    for (int lane = 0; lane < Pendulums::count; ++lane) {
      p.noise_rate[lane] += static_cast<std::ptrdiff_t>(done) * Pendulums::noise_apart;
      p.stimulus[lane] += 2 * intervals_ * static_cast<std::size_t>(done);
      p.samples[lane] += done;
      works_[static_cast<std::size_t>(lane)].samples_left -= done;
    }
  }

  /// The commands that a lane can still ask for go to where there is room behind them.
  void move_commands_back() {
    Pendulums& p = *lanes_;
    int lag = 0;
    for (const Work& work : works_) lag = std::max(lag, work.lag);
    const int shift = p.row - Pendulums::longest_lag;
    const auto at = [&](int row) { return p.commands + static_cast<std::ptrdiff_t>(row) * Pendulums::count; };
    std::copy(at(p.row - lag), at(p.row), at(p.row - lag - shift));
    p.row -= shift;
    p.last_first_row -= shift;
    for (double& row : p.first_row) row -= shift;
  }

  void end_if_over(int lane, const Simulator::Finished& finished) {
    const Work work = works_[static_cast<std::size_t>(lane)];
    const double largest = lanes_->largest[lane];
    const bool valid = largest <= sway_limit_rad;  // false for NaN
    if (valid && work.samples_left > 0) return;
    const double end_s = static_cast<double>(setting_.samples - work.samples_left) / setting_.protocol.sample_rate_hz;
    rest(lane);
    if (work.noise != nullptr) --work.noise->users;
    if (work.index < 0) return;
    const double infinite = std::numeric_limits<double>::infinity();
    finished(work.index, {valid, std::isnan(largest) ? infinite : largest, end_s}, {sway_of(lane), samples_});
  }

  Setting setting_;
  AdvancePendulums advance_;
  std::size_t samples_, intervals_;  // intervals: of the stimulus, a sample
  double step_over_inertia_;
  Course course_{};
  std::unique_ptr<Pendulums> lanes_;
  std::array<Work, Pendulums::count> works_{};
  std::vector<double> silence_;
  std::unique_ptr<double[]> sways_;  // a row a lane, and one for those at rest
  std::vector<std::unique_ptr<Noise>> noises_;
  std::vector<Prepared> waiting_;
};

}  // namespace

double dead_band(double x, double theta) {
  return x - std::clamp(x, -theta, theta);
}

Simulator::Simulator(Protocol protocol, Isa isa)
    : protocol_(checked(std::move(protocol))),
      isa_(isa),
      stimulus_(make_stimulus(protocol_)),
      noise_maker_(protocol_),
      samples_(protocol_.samples()) {
  for (std::size_t i = 0; i < stimulus_.rate_rad_s.size(); ++i) {
    tilt_and_rate_.push_back(stimulus_.tilt_rad[i]);
    tilt_and_rate_.push_back(stimulus_.rate_rad_s[i]);
  }
}

Outcome Simulator::run(const Parameters& parameters, const Random& noise, std::span<double> sway_rad) const {
  if (sway_rad.size() != static_cast<std::size_t>(samples_)) {
    throw Error("simulation", "the output holds " + std::to_string(sway_rad.size()) + " samples",
                "make room for " + std::to_string(samples_));
  }
  Outcome result{};
  int next = 0;
  Lanes({protocol_, noise_maker_, tilt_and_rate_, samples_, isa_})
      .run([&] { return next == 0 ? next++ : -1; },
           [&](int) {
             return Trial{parameters, noise};
           },
           [&](int, const Outcome& outcome, std::span<double> sway) {
             result = outcome;
             const auto written =
                 static_cast<std::ptrdiff_t>(std::floor(outcome.end_s * protocol_.sample_rate_hz + 0.5));
             std::copy(sway.begin(), sway.begin() + written, sway_rad.begin());
           });
  return result;
}

void Simulator::run_all(int count, const TrialOf& trial_of, const Finished& finished) const {
  // A trial goes to whichever thread has a lane free.
  constexpr int worth_a_thread = 8;
  std::atomic<int> first{0};
  const auto next = [&] {
    const int index = first.fetch_add(1);
    return index < count ? index : -1;
  };
  const int threads = std::min(thread_count(), (count + worth_a_thread - 1) / worth_a_thread);
  parallel_for(threads, [&](int) {
    Lanes({protocol_, noise_maker_, tilt_and_rate_, samples_, isa_}).run(next, trial_of, finished);
  });
}

Complex closed_loop(const Parameters& parameters, const Body& body, double frequency_hz) {
  // exp(-s delay) turns by frequency * delay; whole turns do not count.
  constexpr long long parts = 1LL << 52;
  const double turns = frequency_hz * parameters[Delay];
  const double part = (turns - std::floor(turns)) * static_cast<double>(parts);
  const auto [sin, cos] = sincos_of_turn(static_cast<long long>(part), parts);
  const double omega = 2.0 * pi * frequency_hz;
  const Complex passive{parameters[Kp_pass], omega * parameters[Kd_pass]};
  // 2 (Kp + s Kd) (cos - i sin)
  const double kp = parameters[Kp], omega_kd = omega * parameters[Kd];
  const Complex active{2.0 * (kp * cos + omega_kd * sin), 2.0 * (omega_kd * cos - kp * sin)};
  const Complex d{-body.inertia_kgm2 * omega * omega - body.mgh() + active.real() + passive.real(),
                  active.imag() + passive.imag()};
  const double norm = d.real() * d.real() + d.imag() * d.imag();
  return {(passive.real() * d.real() + passive.imag() * d.imag()) / norm,
          (passive.imag() * d.real() - passive.real() * d.imag()) / norm};
}

}  // namespace decid::sim
