// Trials in lanes: see lanes.hpp.
#include "sim/lanes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.hpp"
#include "sim/detail/controller.hpp"
#include "sim/protocol/detail/checker.hpp"

namespace decid::sim {
namespace {

// (sin a - a) / a^3 for |a| <= 5 degrees as a polynomial in a^2 with the smallest relative error of the sine for its
// degree, 8.5e-17 (Remez exchange in 50 digits). Rounding adds at most half a unit in the last place of a. Beyond the
// bound, where a trial is over, the error grows slowly.
constexpr double sine_coefficients[] = {-0.16666666666644338547, 0.0083333331554029862068, -0.00019837239079875674672};

static_assert(longest_delay_s * steps_per_second <= Pendulums::longest_lag);

}  // namespace

StepConstants make_step_constants(const Experiment& experiment, const Stimulus& stimulus) {
  StepConstants step_constants{};
  step_constants.step_s = integration_step_s;
  step_constants.steps_per_sample = experiment.steps_per_sample();
  step_constants.per_step = 1.0 / step_constants.steps_per_sample;
  const std::size_t intervals = stimulus.rate_rad_s.size() / static_cast<std::size_t>(experiment.samples());
  step_constants.interval_steps = step_constants.steps_per_sample / static_cast<int>(intervals);
  step_constants.sway_limit_rad = sway_limit_rad;
  const Family& family = experiment.family();
  step_constants.unit_gains = family.has_unit_gains();
  step_constants.slow_leak = 1.0 / family.slow_time_s;
  step_constants.torque_leak = 1.0 / family.torque_time_s;
  return step_constants;
}

std::array<double, 3> sine_coefficients_for(const Body& body) {
  std::array<double, 3> all{};
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i] = integration_step_s / body.inertia_kgm2 * body.mgh() * sine_coefficients[i];
  return all;
}

Setup::Setup(Protocol valid_protocol, Isa isa_used)
    : protocol(std::move(valid_protocol)),
      isa(isa_used),
      stimulus(make_stimulus(protocol.experiment)),
      noise_maker(protocol),
      samples(protocol.samples()) {
  for (std::size_t i = 0; i < stimulus.rate_rad_s.size(); ++i) {
    tilt_and_rate.push_back(stimulus.tilt_rad[i]);
    tilt_and_rate.push_back(stimulus.rate_rad_s[i]);
  }
}

Lanes::Lanes(const Setup& setup)
    : setup_(setup),
      advance_(simulator_kernels(setup.isa).advance_pendulums),
      samples_(static_cast<std::size_t>(setup.samples)),
      lanes_(std::make_unique<Pendulums>()),
      silence_((samples_ + 1) * fft_lanes, 0.0),
      sways_(std::make_unique_for_overwrite<double[]>((Pendulums::count + 1) * samples_)) {
  step_constants_ = make_step_constants(setup.protocol.experiment, setup.stimulus);
  step_constants_.gravity_dead_band = setup.protocol.gravity_dead_band_deg * rad_per_deg;
  step_constants_.unit_gains = step_constants_.unit_gains && step_constants_.gravity_dead_band == 0.0;
  intervals_ = setup.stimulus.rate_rad_s.size() / samples_;
  lanes_->row = Pendulums::longest_lag;
  for (int lane = 0; lane < Pendulums::count; ++lane) rest(lane);
}

void Lanes::run(const std::function<int()>& next, const Simulator::TrialOf& make_trial,
                const Simulator::Finished& finished) {
  for (;;) {
    int busy = 0, samples = setup_.samples;  // busy: the number of lanes up to the last busy one
    for (int lane = 0; lane < Pendulums::count; ++lane) {
      Work& work = works_[static_cast<std::size_t>(lane)];
      if (work.index < 0) {
        if (waiting_.empty()) prepare(next, make_trial);
        if (!waiting_.empty()) {
          begin(lane, waiting_.back(), sway_of(lane));
          waiting_.pop_back();
        }
      }
      if (work.index >= 0) busy = lane + 1;
      samples = std::min(samples, work.samples_left);
    }
    if (busy == 0) return;
    lanes_->lanes = busy;
    advance(samples);
    for (int lane = 0; lane < Pendulums::count; ++lane) end_if_over(lane, finished);
  }
}

void Lanes::prepare(const std::function<int()>& next, const Simulator::TrialOf& make_trial) {
  constexpr std::size_t max_waiting = fft_lanes;
  std::vector<double> nv;
  std::vector<Random> random;
  NoiseBlock* noise = nullptr;
  while (waiting_.size() < max_waiting) {
    const int index = next();
    if (index < 0) break;
    const std::size_t column = waiting_.size();
    const TrialInput trial = make_trial(index);
    check_parameters(trial.parameters, setup_.protocol.parameters());
    if (!(trial.height >= 0.1 && trial.height <= 10.0))
      throw Error(Code::setting_out_of_range, "trial",
                  "has a body height of " + given_text(trial.height) + " times the protocol's", "give 0.1 to 10 times");
    const Coefficients coefficients = setup_.protocol.family().coefficients(trial.parameters);
    waiting_.push_back(
        {index, coefficients, setup_.protocol.experiment.body.of_height(trial.height), nullptr, silence_.data()});
    nv.push_back(coefficients[Coefficient::nv]);
    random.push_back(trial.noise);
    if (nv.back() == 0.0) continue;
    if (noise == nullptr) noise = free_noise();
    ++noise->users;
    waiting_.back().noise = noise;
    waiting_.back().noise_rate = noise->rate.data() + column;
  }
  if (noise != nullptr) setup_.noise_maker.velocity_lanes(nv, random, noise->rate, setup_.isa);
  std::reverse(waiting_.begin(), waiting_.end());  // trials are taken from its end
}

Lanes::NoiseBlock* Lanes::free_noise() {
  for (const auto& noise : noises_) {
    if (noise->users == 0) return noise.get();
  }
  noises_.push_back(std::make_unique<NoiseBlock>());
  noises_.back()->rate.resize((samples_ + 1) * fft_lanes);
  return noises_.back().get();
}

void Lanes::rest(int lane) {
  begin(lane, {-1, Coefficients(), setup_.protocol.experiment.body, nullptr, silence_.data()},
        sways_.get() + Pendulums::count * samples_);
  lanes_->k1[lane] = lanes_->k2[lane] = 0.0;
}

void Lanes::begin(int lane, const Prepared& trial, double* sway) {
  Pendulums& p = *lanes_;
  using enum Coefficient;
  const Coefficients& of = trial.coefficients;
  const double c = integration_step_s / trial.body.inertia_kgm2;
  p.passive[lane] = c * of[kp_pass];
  p.damping[lane] = c * of[kd_pass];
  p.k1[lane] = c * (trial.body.mgh() - of[kp_pass]);
  p.k2[lane] = 1.0 - p.damping[lane];
  const std::array<double, 3> sine = sine_coefficients_for(trial.body);
  for (std::size_t i = 0; i < sine.size(); ++i) p.sine[i][lane] = sine[i];
  // With unit gains the sum of servo and gravity estimate is a factor of the command.
  const bool unit_gains = step_constants_.unit_gains;
  const double command = unit_gains ? 2.0 * c : c, scale = unit_gains ? 0.5 : of[tilt];
  p.kp[lane] = command * of[kp];
  p.kd[lane] = command * of[kd];
  p.theta[lane] = scale * of[theta];
  p.minus_theta[lane] = -p.theta[lane];
  p.reach[lane] = of[position] + of[gravity];
  p.tilt[lane] = of[tilt];
  p.tilt_over_servo[lane] = of[tilt] - of[position];
  p.minus_gravity[lane] = -of[gravity];
  p.slow_gain[lane] = of[slow];
  p.torque_gain[lane] = of[torque] / (c * trial.body.mgh());
  const Lag lag(of[delay]);
  p.fraction[lane] = lag.fraction;
  for (double* state : {p.sway, p.sway_rate, p.error, p.newer, p.max_sway, p.slow, p.torque, p.active})
    state[lane] = 0.0;
  p.noise[lane] = scale * trial.noise_rate[0];
  p.noise_rate[lane] = trial.noise_rate;
  p.stimulus[lane] = setup_.tilt_and_rate.data();
  p.samples[lane] = sway;
  p.delayed[lane] = p.commands + lane - static_cast<std::ptrdiff_t>(lag.whole) * Pendulums::count;
  p.first_row[lane] = p.row + lag.first_step;
  p.last_first_row = std::max(p.last_first_row, p.row + lag.first_step);
  works_[static_cast<std::size_t>(lane)] = {trial.index, setup_.samples, lag.whole, trial.noise};
}

void Lanes::advance(int samples) {
  Pendulums& p = *lanes_;
  if (p.row + step_constants_.steps_per_sample > Pendulums::rows) move_commands_back();
  const int done =
      advance_(p, step_constants_, std::min(samples, (Pendulums::rows - p.row) / step_constants_.steps_per_sample));
  p.row += done * step_constants_.steps_per_sample;
  for (int lane = 0; lane < Pendulums::count; ++lane) {
    p.noise_rate[lane] += static_cast<std::ptrdiff_t>(done) * Pendulums::noise_apart;
    p.stimulus[lane] += 2 * intervals_ * static_cast<std::size_t>(done);
    p.samples[lane] += done;
    works_[static_cast<std::size_t>(lane)].samples_left -= done;
  }
}

void Lanes::move_commands_back() {
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

void Lanes::end_if_over(int lane, const Simulator::Finished& finished) {
  const Work work = works_[static_cast<std::size_t>(lane)];
  const double max_sway = lanes_->max_sway[lane];
  const bool valid = max_sway <= sway_limit_rad;  // false for NaN
  if (valid && work.samples_left > 0) return;
  const double end_s =
      static_cast<double>(setup_.samples - work.samples_left) / setup_.protocol.experiment.sample_rate_hz;
  rest(lane);
  if (work.noise != nullptr) --work.noise->users;
  if (work.index < 0) return;
  const double infinite = std::numeric_limits<double>::infinity();
  finished(work.index, {valid, std::isnan(max_sway) ? infinite : max_sway, end_s}, {sway_of(lane), samples_});
}

}  // namespace decid::sim
