// A trial: see simulate.hpp for the equations and the choices made where the paper is silent.
// The step is plain multiply and add on a type Real without branches: several trials in the lanes of one vector would
// have the same bits as one at a time.
#include "sim/simulate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/math.hpp"
#include "base/parallel.hpp"

namespace decid::sim {
namespace {

constexpr double step_s = 1.0 / steps_per_second;

// x without its part within [-theta, theta]: the definition in one subtraction.
template <class Real>
Real dead_band_of(Real x, Real theta) {
  const Real within = x < -theta ? -theta : (x > theta ? theta : x);
  return x - within;
}

template <class Real>
struct Controller {
  Real kp, kd, kp_pass, kd_pass, theta;
};

struct Plant {
  explicit Plant(const Body& body) : mgh(body.mgh()), step_over_inertia(step_s / body.inertia_kgm2) {}
  double mgh, step_over_inertia;
};

// The platform at the start of a step.
struct Platform {
  double tilt, rate;
};

template <class Real>
struct State {
  Real sway, sway_rate;
  Real tilt_estimate;
};

// The active torque that the controller commands now, sign as in u; integrates the tilt estimate over the step.
template <class Real>
Real command(const Controller<Real>& controller, State<Real>& state, Platform platform, Real noise_rate) {
  const Real estimate_rate = dead_band_of<Real>(platform.rate + noise_rate, controller.theta);
  const Real angle = 2.0 * state.sway + (state.tilt_estimate - platform.tilt);
  const Real rate = 2.0 * state.sway_rate + (estimate_rate - platform.rate);
  state.tilt_estimate = state.tilt_estimate + step_s * estimate_rate;
  return controller.kp * angle + controller.kd * rate;
}

// One semi-implicit Euler step of the body: torques from the state at the start, velocity first.
template <class Real>
void move(const Controller<Real>& controller, const Plant& plant, State<Real>& state, Platform platform, Real active) {
  const Real passive =
      controller.kp_pass * (state.sway - platform.tilt) + controller.kd_pass * (state.sway_rate - platform.rate);
  const Real torque = plant.mgh * sin_small(state.sway) - (active + passive);
  state.sway_rate = state.sway_rate + plant.step_over_inertia * torque;
  state.sway = state.sway + step_s * state.sway_rate;
}

// What was commanded a delay ago: linear between the two neighbouring steps, zero while the trial is younger.
class DelayLine {
 public:
  explicit DelayLine(double delay_s) {
    double steps = delay_s * steps_per_second;
    // A delay of whole milliseconds is one, whatever the rounding of its product.
    const double nearest = std::floor(steps + 0.5);
    if (std::abs(steps - nearest) < 1e-9) steps = nearest;
    whole_ = static_cast<unsigned>(steps);
    fraction_ = steps - whole_;
    first_step_ = static_cast<int>(std::ceil(steps));
  }

  /// Takes the command of this step, which is the one returned if there is no delay.
  double pass(int step, double value) {
    const auto now = static_cast<unsigned>(step);
    ring_[now % slots] = value;
    if (step < first_step_) return 0.0;
    const double newer = ring_[(now - whole_) % slots];
    const double older = ring_[(now - whole_ - 1) % slots];
    return newer + fraction_ * (older - newer);
  }

 private:
  static constexpr unsigned slots = 1024;  // a power of two, so that the index may wrap
  static_assert(longest_delay_s * steps_per_second + 2 <= slots);
  std::array<double, slots> ring_{};
  unsigned whole_;
  double fraction_;
  int first_step_;
};

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

}  // namespace

double dead_band(double x, double theta) {
  return dead_band_of(x, theta);
}

Simulator::Simulator(Protocol protocol)
    : protocol_(checked(std::move(protocol))),
      stimulus_(make_stimulus(protocol_)),
      noise_maker_(protocol_),
      samples_(protocol_.samples()) {}

Outcome Simulator::run(const Parameters& parameters, const Random& noise, std::span<double> sway_rad) const {
  check_parameters(parameters);
  const auto samples = static_cast<std::size_t>(samples_);
  if (sway_rad.size() != samples) {
    throw Error("simulation", "the output holds " + std::to_string(sway_rad.size()) + " samples",
                "make room for " + std::to_string(samples));
  }
  std::vector<double> noise_rate(samples + 1, 0.0);
  if (parameters[Nv] > 0.0) noise_maker_.velocity(parameters[Nv], noise, noise_rate);

  const Controller<double> controller{.kp = parameters[Kp],
                                      .kd = parameters[Kd],
                                      .kp_pass = parameters[Kp_pass],
                                      .kd_pass = parameters[Kd_pass],
                                      .theta = parameters[Theta]};
  const Plant plant(protocol_.body);
  DelayLine delay_line(parameters[Delay]);
  State<double> state{};
  double largest_sway = 0.0;
  const int steps_per_sample = protocol_.steps_per_sample();
  int step = 0;
  for (std::size_t sample = 0; sample < samples; ++sample) {
    sway_rad[sample] = state.sway;
    const double noise_slope = (noise_rate[sample + 1] - noise_rate[sample]) / steps_per_sample;
    for (int i = 0; i < steps_per_sample; ++i, ++step) {
      const Platform platform{stimulus_.tilt_at(step), stimulus_.rate_at(step)};
      const double commanded = command(controller, state, platform, noise_rate[sample] + i * noise_slope);
      move(controller, plant, state, platform, delay_line.pass(step, commanded));

      const double magnitude = std::abs(state.sway);
      if (!(magnitude <= sway_limit_rad)) {  // NaN included
        const double largest = std::isnan(magnitude) ? std::numeric_limits<double>::infinity() : magnitude;
        return {.valid = false, .largest_sway_rad = largest, .end_s = static_cast<double>(step + 1) / steps_per_second};
      }
      largest_sway = std::max(largest_sway, magnitude);
    }
  }
  return {.valid = true, .largest_sway_rad = largest_sway, .end_s = protocol_.duration_s()};
}

void Simulator::run_all(int count, const TrialOf& trial_of, const Finished& finished) const {
  parallel_for(count, [&](int index) {
    thread_local std::vector<double> sway;
    sway.resize(static_cast<std::size_t>(samples_));
    const Trial trial = trial_of(index);
    const Outcome outcome = run(trial.parameters, trial.noise, sway);
    finished(index, outcome, sway);
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
