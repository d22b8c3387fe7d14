// The posterior density of a recorded trial: see density.hpp.
#include "identify/posterior/density.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <string>

#include "base/error.hpp"
#include "base/math.hpp"
#include "base/random.hpp"
#include "base/text.hpp"
#include "identify/posterior/chains.hpp"
#include "identify/posterior/elementary.hpp"
#include "sim/simulate.hpp"

namespace decid::posterior {
namespace {

using sim::Complex;

constexpr double full_hz = 3.0, top_hz = 5.0, block_ms = 100.0, bin_ms = 50.0;
constexpr double whole_damping = 10.0;  // c times the transforms' length: what wraps around is e^-10 of itself
constexpr int spare_blocks = 40;        // of the transforms, beside the trial: more than the latest start
constexpr double nv_scale = 0.05;       // kappa: below it the noise's coefficients are non-centred
constexpr int fewest_blocks = 20;

constexpr double model_error_deg = 0.0005;                  // of a block's mean (the test compares with the simulator)
constexpr double latest_start_s = 1.0, largest_gain = 0.9;  // so that the loop's turns are small, and the gain positive

const Priors& checked(const Priors& priors) {
  const auto check = [](bool right, const char* setting, double value, const char* remedy) {
    if (!right) throw Error(std::string("priors, ") + setting, format("is %g", value), remedy);
  };
  check(priors.sensor_noise_deg > 0.0 && std::isfinite(priors.sensor_noise_deg), "sensor_noise_deg",
        priors.sensor_noise_deg, "give degrees above 0");
  check(priors.sensor_noise_factor > 1.0 && std::isfinite(priors.sensor_noise_factor), "sensor_noise_factor",
        priors.sensor_noise_factor, "give a factor above 1");
  check(priors.start_s >= 0.0 && priors.start_s <= latest_start_s, "start_s", priors.start_s, "give 0 to 1 s");
  check(priors.gain >= 0.0 && priors.gain <= largest_gain, "gain", priors.gain, "give 0 to 0.9");
  check(priors.drift_hz >= 0.0 && std::isfinite(priors.drift_hz), "drift_hz", priors.drift_hz, "give 0 Hz or more");
  return priors;
}

/// Samples in a block, for blocks of about 100 ms.
int samples_per_block(const sim::Experiment& experiment) {
  return std::max(1, static_cast<int>(std::floor(block_ms / experiment.steps_per_sample() + 0.5)));
}

/// Steps in a bin: the divisor of a block that is nearest to bin_ms.
int steps_per_bin(int block_steps) {
  int best = block_steps;
  for (int steps = 1; steps <= block_steps; ++steps) {
    if (block_steps % steps == 0 && std::abs(steps - bin_ms) < std::abs(best - bin_ms)) best = steps;
  }
  return best;
}

/// Where a bin begins, -bin_steps < step <= 0, so that the platform's velocity steps between bins; 0 if it steps
/// elsewhere too.
int first_step_of(const sim::Stimulus& stimulus, int bin_steps) {
  int place = -1;
  for (std::size_t i = 1; i < stimulus.rate_rad_s.size(); ++i) {
    if (stimulus.rate_rad_s[i] == stimulus.rate_rad_s[i - 1]) continue;
    const int here = static_cast<int>(i) * stimulus.interval_steps % bin_steps;
    if (place >= 0 && here != place) return 0;
    place = here;
  }
  return place <= 0 ? 0 : place - bin_steps;
}

/// z = exp(s T) at frequency k, T one step.
Complex step_turn(double damping, long long k, long long steps) {
  const auto [sin, cos] = sincos_of_turn(k, steps);
  const double size = decid::exp(damping * sim::integration_step_s);
  return {size * cos, size * sin};
}

/// The share of a frequency that is looked at: 1, then down to 0 with all derivatives. A sharp edge rings through the
/// whole trial, and undoing the damping raises that.
double kept(double hz) {
  const double u = (hz - full_hz) / (top_hz - full_hz);
  if (u <= 0.0) return 1.0;
  if (u >= 1.0) return 0.0;
  return 1.0 / (1.0 + decid::exp(std::clamp(1.0 / (1.0 - u) - 1.0 / u, -700.0, 700.0)));
}

/// (sin a - a), by its series: |a| stays below 0.1.
double sine_excess(double a) {
  const double z = a * a;
  return a * z * (-1.0 / 6 + z * (1.0 / 120 - z * (1.0 / 5040)));
}

void put(AlignedVector<double>& values, Complex value) {
  values.push_back(value.real());
  values.push_back(value.imag());
}

}  // namespace

const sim::Protocol& of_single_pendulum(const sim::Protocol& protocol) {
  protocol.validate();
  if (&protocol.parameters() != &sim::single_pendulum().parameters)
    throw Error("protocol " + protocol.name, "has another body model than the single pendulum",
                "use a protocol of the single pendulum");
  return protocol;
}

Density::Density(const sim::Protocol& protocol, const Priors& priors, Isa isa)
    : protocol_(of_single_pendulum(protocol)),
      priors_(checked(priors)),
      ranges_(protocol.ranges()),
      isa_(isa),
      block_samples_(samples_per_block(protocol.experiment)),
      bin_steps_(steps_per_bin(block_samples_ * protocol.experiment.steps_per_sample())),
      first_step_(0),
      bins_(0),
      padded_bins_(0),
      padded_blocks_(sim::smooth_length(protocol.samples() / block_samples_ + spare_blocks)),
      blocks_(protocol.samples() / block_samples_),
      frequencies_(0),
      damping_(0.0),
      drift_decay_(0.0),
      noise_(protocol, bin_steps_, protocol.experiment.steps() / bin_steps_ + 8, top_hz),
      bins_fft_(padded_blocks_ * (block_samples_ * protocol.experiment.steps_per_sample() / bin_steps_)),
      blocks_fft_(padded_blocks_) {
  if (blocks_ < fewest_blocks) {
    throw Error("protocol " + protocol.name, format("lasts %g s", protocol.duration_s()),
                "the posterior needs 2 s at least");
  }
  if (noise_.size() == 0 && protocol.noise.vestibular.scale_deg > 0.0) {
    throw Error("protocol " + protocol.name + ", vestibular_noise", "has a single frequency",
                "widen low_hz to high_hz; the posterior takes the noise for a band");
  }
  const sim::Experiment& experiment = protocol.experiment;
  const int block_steps = block_samples_ * experiment.steps_per_sample();
  const double block_s = block_steps * sim::integration_step_s, step_s = sim::integration_step_s;
  const double padded_s = padded_blocks_ * block_s;
  const long long padded_steps = static_cast<long long>(padded_blocks_) * block_steps;
  padded_bins_ = bins_fft_.length();
  damping_ = whole_damping / padded_s;
  drift_decay_ = decid::exp(-2.0 * sim::pi * priors.drift_hz * block_s);
  frequencies_ = std::min(static_cast<int>(top_hz * padded_s), padded_blocks_ / 2);

  const sim::Stimulus stimulus = sim::make_stimulus(experiment);
  const int steps = experiment.steps();
  first_step_ = first_step_of(stimulus, bin_steps_);
  bins_ = (steps - first_step_ + bin_steps_ - 1) / bin_steps_ + 5;
  const auto rate_at = [&](int step) { return stimulus.rate_at(std::clamp(step, 0, steps - 1)); };
  for (int half = 0; half < 2 * bins_; ++half) {
    // The line of least squares through the half's steps.
    const int bin_from = first_step_ + half / 2 * bin_steps_, first = bin_steps_ / 2;
    const int from = bin_from + half % 2 * first, count = half % 2 == 0 ? first : bin_steps_ - first;
    const int length = std::max(1, count);  // a bin of one step has itself for both halves
    double mean = 0.0, slope = 0.0, squares = 0.0;
    for (int j = 0; j < length; ++j) {
      const double place = j - 0.5 * (length - 1);
      mean += rate_at(from + j) / length;
      slope += place * rate_at(from + j);
      squares += place * place;
    }
    slope = length > 1 ? slope / squares : 0.0;
    rate_low_.push_back(mean - 0.5 * length * slope);
    rate_high_.push_back(mean + 0.5 * length * slope);
    const int here = std::clamp(from + length, 0, length);  // steps before the trial's start do not count
    weight_.push_back(decid::exp(-damping_ * step_s * bin_from) * here / length);
  }

  // The platform's transform, from its steps.
  const sim::RealFft steps_fft(static_cast<int>(padded_steps));
  std::vector<double> rates(static_cast<std::size_t>(padded_steps), 0.0);
  for (int step = 0; step < std::min<long long>(steps + bin_steps_ * 4, padded_steps); ++step)
    rates[static_cast<std::size_t>(step)] = rate_at(step) * decid::exp(-damping_ * step_s * step);
  std::vector<Complex> spectrum(static_cast<std::size_t>(steps_fft.bins()));
  std::vector<Complex> work(static_cast<std::size_t>(steps_fft.work_length()));
  steps_fft.forward(rates, spectrum, work);

  const double inertia = experiment.body.inertia_kgm2, mgh = experiment.body.mgh();
  for (int k = 0; k < frequencies_; ++k) {
    const Complex z = step_turn(damping_, k, padded_steps);
    put(s_, {damping_, 2.0 * sim::pi * k / padded_s});
    put(sum_, quotient(step_s, z - 1.0));
    put(rate_, quotient(z - 1.0, step_s * z));
    put(body_, quotient(inertia * (z - 1.0) * (z - 1.0), step_s * step_s * z) - mgh);
    Complex hold = 0.0, power = 1.0;
    const Complex step_back = quotient(1.0, z);
    for (int j = 0; j < bin_steps_; ++j, power *= step_back) hold += power;
    const auto [sin, cos] = sincos_of_turn(static_cast<long long>(k) * first_step_, padded_steps);
    put(hold_, hold * Complex(cos, -sin));
    Complex sample = 1.0, mean = 0.0, turn = 1.0;
    for (int j = 0; j < experiment.steps_per_sample(); ++j) turn *= z;
    for (int j = 0; j < block_samples_; ++j, sample *= turn) mean += sample;
    put(observe_, mean * (kept(k / padded_s) / block_samples_));
    put(platform_, spectrum[static_cast<std::size_t>(k)]);
  }
  for (int block = 0; block < blocks_; ++block)
    undamp_.push_back(decid::exp(damping_ * block_s * block) * padded_blocks_ / static_cast<double>(padded_steps));
}

Density::Transforms Density::transforms() const {
  return {bins_fft_.length(), blocks_fft_.length(), noise_.transform_length(), noise_.transforms()};
}

double Density::block_noise_rad(double sensor_noise_deg) const {
  const double of_sensor = sensor_noise_deg / std::sqrt(static_cast<double>(block_samples_));
  return std::sqrt(of_sensor * of_sensor + model_error_deg * model_error_deg) * sim::rad_per_deg;
}

Observation Density::observe(std::span<const float> sway_rad) const {
  if (sway_rad.size() != static_cast<std::size_t>(protocol_.samples())) {
    throw Error("recording", "has " + std::to_string(sway_rad.size()) + " samples",
                "give the protocol's " + std::to_string(protocol_.samples()));
  }
  Observation observation;
  for (int block = 0; block < blocks_; ++block) {
    double sum = 0.0;
    for (int j = 0; j < block_samples_; ++j)
      sum += double{sway_rad[static_cast<std::size_t>(block * block_samples_ + j)]};
    observation.sway.push_back(sum / block_samples_);
  }
  double squares = 0.0;
  for (std::size_t i = 2; i < sway_rad.size(); ++i) {
    const double second = double{sway_rad[i]} - 2.0 * double{sway_rad[i - 1]} + double{sway_rad[i - 2]};
    squares += second * second;
  }
  observation.noise_deg = std::sqrt(squares / 6.0 / static_cast<double>(sway_rad.size() - 2)) / sim::rad_per_deg;

  const double block_s = block_samples_ / protocol_.experiment.sample_rate_hz;
  const double middle_s = 0.5 * (block_samples_ - 1) / protocol_.experiment.sample_rate_hz;
  const double mgh = protocol_.experiment.body.mgh();
  std::vector<double> torque(static_cast<std::size_t>(padded_blocks_), 0.0);
  for (int block = 0; block < blocks_; ++block) {
    double sum = 0.0;
    int count = 0;
    for (int j = std::max(0, block - 1); j <= std::min(blocks_ - 1, block + 1); ++j, ++count)
      sum += observation.sway[static_cast<std::size_t>(j)];
    torque[static_cast<std::size_t>(block)] =
        mgh * sine_excess(sum / count) * decid::exp(-damping_ * (block_s * block + middle_s));
  }
  std::vector<Complex> spectrum(static_cast<std::size_t>(blocks_fft_.bins()));
  std::vector<Complex> work(static_cast<std::size_t>(blocks_fft_.work_length()));
  blocks_fft_.forward(torque, spectrum, work);
  const long long middle_steps = static_cast<long long>(block_samples_ - 1) * protocol_.experiment.steps_per_sample();
  const long long padded_steps = static_cast<long long>(padded_bins_) * bin_steps_;
  for (int k = 0; k < frequencies_; ++k) {
    const auto [sin, cos] = sincos_of_turn(k * middle_steps, 2 * padded_steps);
    put(observation.torque,
        spectrum[static_cast<std::size_t>(k)] * Complex(cos, -sin) * (block_s / sim::integration_step_s));
  }
  return observation;
}

State Density::state(std::span<const double> x, int chain) const {
  const auto at = [&](int global) { return x[static_cast<std::size_t>((noise_.size() + global) * lanes + chain)]; };
  State state;
  const sim::ParameterTable& table = ranges_;
  state.parameters = sim::Parameters(table.size());
  for (std::size_t i = 0; i < table.size(); ++i)
    state.parameters[i] = table[i].low + table[i].range() * normal_distribution(at(static_cast<int>(i)));
  state.sensor_noise_deg =
      priors_.sensor_noise_deg * decid::exp(decid::log(priors_.sensor_noise_factor) * at(sensor_noise));
  state.start_s = priors_.start_s * (2.0 * normal_distribution(at(start)) - 1.0);
  state.gain = 1.0 + priors_.gain * (2.0 * normal_distribution(at(gain)) - 1.0);
  return state;
}

void Density::set(const State& state, std::span<double> x, int chain) const {
  const auto at = [&](int global) -> double& {
    return x[static_cast<std::size_t>((noise_.size() + global) * lanes + chain)];
  };
  const auto probit = [](double share) { return inverse_normal(std::clamp(share, 0.01, 0.99)); };
  const sim::ParameterTable& table = ranges_;
  for (std::size_t i = 0; i < table.size(); ++i)
    at(static_cast<int>(i)) = probit((state.parameters[i] - table[i].low) / table[i].range());
  at(sensor_noise) = noise_coordinate(state.sensor_noise_deg);
  at(start) = priors_.start_s > 0.0 ? probit(0.5 * (1.0 + state.start_s / priors_.start_s)) : 0.0;
  at(gain) = priors_.gain > 0.0 ? probit(0.5 * (1.0 + (state.gain - 1.0) / priors_.gain)) : 0.0;
}

double Density::noise_coordinate(double sensor_noise_deg) const {
  return decid::log(sensor_noise_deg / priors_.sensor_noise_deg) / decid::log(priors_.sensor_noise_factor);
}

Density::Workspace::Workspace(const Density& d) {
  const auto of = [](int count) { return static_cast<std::size_t>(count) * lanes; };
  for (auto* values : {&velocity, &by_velocity}) values->assign(of(d.noise_.edges()), 0.0);
  for (auto* values : {&fine, &by_fine}) values->assign(of(2 * d.bins_ + 1), 0.0);
  for (auto* values : {&halves, &by_halves, &by_low, &by_high, &by_theta}) values->assign(of(2 * d.bins_), 0.0);
  for (auto* values : {&passed, &by_passed}) values->assign(of(d.padded_bins_), 0.0);
  bins_spectrum.assign(of(2 * d.bins_fft_.bins()), 0.0);
  loop_spectrum.assign(of(2 * d.bins_fft_.bins()), 0.0);
  sway_spectrum.assign(of(2 * d.blocks_fft_.bins()), 0.0);
  for (auto* values : {&delayed, &inverse, &sway, &observe, &response}) values->assign(of(2 * d.frequencies_), 0.0);
  modelled.assign(of(d.padded_blocks_), 0.0);
  residual.assign(of(d.padded_blocks_), 0.0);
  fft_work.assign(of(2 * std::max(d.bins_fft_.work_length(), d.blocks_fft_.work_length())), 0.0);
  noise_work.assign(d.noise_.work_size(), 0.0);
}

Density::Chains Density::chains(std::span<const double> x, std::optional<double> fixed_noise_deg) const {
  Chains c;
  const sim::ParameterTable& table = ranges_;
  const double padded_s = padded_bins_ * bin_steps_ * sim::integration_step_s;
  for (std::size_t l = 0; l < lanes; ++l) {
    const auto coordinate = [&](int global) { return x[static_cast<std::size_t>(noise_.size() + global) * lanes + l]; };
    const auto uniform = [&](std::size_t global, double low, double range) {
      const double at = coordinate(static_cast<int>(global));
      c.value[global][l] = low + range * normal_distribution(at);
      c.by_coordinate[global][l] = range * normal_density(at);
    };
    for (std::size_t i = 0; i < table.size(); ++i) uniform(i, table[i].low, table[i].range());
    uniform(start, -priors_.start_s, 2.0 * priors_.start_s);
    uniform(gain, 1.0 - priors_.gain, 2.0 * priors_.gain);
    const double spread = decid::log(priors_.sensor_noise_factor);
    const double noise_deg =
        fixed_noise_deg.value_or(priors_.sensor_noise_deg * decid::exp(spread * coordinate(sensor_noise)));
    c.value[sensor_noise][l] = noise_deg;
    c.noise_rad[l] = block_noise_rad(noise_deg);
    const double of_model = model_error_deg * sim::rad_per_deg / c.noise_rad[l];
    // Of the logarithm of the block's noise.
    c.by_coordinate[sensor_noise][l] = fixed_noise_deg ? 0.0 : spread * (1.0 - of_model * of_model);
    const double nv = c.value[sim::Nv][l], radius = std::sqrt(nv * nv + nv_scale * nv_scale);
    c.radius[l] = radius;
    c.noise_gain[l] = nv / radius;
    c.by_nv[l] = nv_scale * nv_scale / (radius * radius * radius);
    const double angle = 2.0 * sim::pi / padded_s;
    const double delay_s = c.value[sim::Delay][l], start_s = c.value[start][l];
    c.delay_first[0][l] = decid::exp(-damping_ * delay_s);
    c.delay_first[1][l] = 0.0;
    c.delay_turn[0][l] = cos_small(angle * delay_s);
    c.delay_turn[1][l] = -sin_small(angle * delay_s);
    c.start_first[0][l] = decid::exp(damping_ * start_s);
    c.start_first[1][l] = 0.0;
    c.start_turn[0][l] = cos_small(angle * start_s);
    c.start_turn[1][l] = sin_small(angle * start_s);
  }
  return c;
}

LoopParameters Density::loop_parameters(const Chains& c) const {
  return {c.value[sim::Kp].data(),      c.value[sim::Kd].data(), c.value[sim::Kp_pass].data(),
          c.value[sim::Kd_pass].data(), c.value[gain].data(),    c.delay_first[0].data(),
          c.delay_turn[0].data(),       c.start_first[0].data(), c.start_turn[0].data()};
}

DeadBandBins Density::halves() const {
  return {2 * bins_, rate_low_.data(), rate_high_.data(), weight_.data()};
}

DeadBandValues Density::dead_band_values(const Chains& c, Workspace& work) const {
  return {work.fine.data(),   c.noise_gain.data(), c.value[sim::Theta].data(), work.halves.data(),
          work.by_low.data(), work.by_high.data(), work.by_theta.data()};
}

LoopConstants Density::constants(const Observation& observation) const {
  return {frequencies_,        s_.data(),        sum_.data(),
          rate_.data(),        body_.data(),     hold_.data(),
          observe_.data(),     platform_.data(), observation.torque.data(),
          2.0 / padded_blocks_};
}

void Density::check(const Observation& observation, std::span<const double> x, std::size_t results,
                    std::size_t expected) const {
  const auto all = static_cast<std::size_t>(size()) * lanes;
  if (x.size() == all && results == expected && observation.sway.size() == static_cast<std::size_t>(blocks_) &&
      observation.torque.size() == s_.size())
    return;
  throw Error("posterior", format("%zu coordinates and room for %zu results", x.size(), results),
              format("give %zu and %zu, and what observe() of this density made", all, expected));
}

void Density::to_blocks(Workspace& work) const {
  blocks_fft_.inverse_lanes(work.sway_spectrum, work.modelled, work.fft_work, isa_);
}

void Density::forward(const Observation& observation, std::span<const double> x, const Chains& c, Workspace& work,
                      double* squares) const {
  const Kernels& run = kernels(isa_);
  noise_.synthesize(x.data(), work.velocity.data(), work.noise_work.data(), isa_);
  run.refine(bins_ + 1, work.velocity.data(), work.fine.data());
  run.dead_band(halves(), dead_band_values(c, work));
  run.join(bins_, work.halves.data(), work.passed.data());
  bins_fft_.forward_lanes(work.passed, work.bins_spectrum, work.fft_work, isa_);
  run.loop(constants(observation), loop_parameters(c),
           {work.bins_spectrum.data(), work.delayed.data(), work.inverse.data(), work.sway.data(), work.observe.data(),
            work.sway_spectrum.data()});
  to_blocks(work);
  run.residual(blocks_, drift_decay_, observation.sway.data(), work.modelled.data(), undamp_.data(),
               work.residual.data(), squares);
}

void Density::evaluate(const Observation& observation, std::span<const double> x, std::span<double> gradient,
                       std::span<double> potential, Workspace& work, std::optional<double> fixed_noise_deg) const {
  check(observation, x, gradient.size() + potential.size(), x.size() + lanes);
  const Kernels& run = kernels(isa_);
  const Chains c = chains(x, fixed_noise_deg);
  std::array<double, lanes> squares, by_gain, by_theta;
  forward(observation, x, c, work, squares.data());

  run.residual_gradient(blocks_, drift_decay_, undamp_.data(), work.residual.data());
  std::fill(work.residual.begin() + blocks_ * lanes, work.residual.end(), 0.0);
  blocks_fft_.forward_lanes(work.residual, work.sway_spectrum, work.fft_work, isa_);
  std::array<double, 7 * lanes> sums;
  const LoopState state{work.bins_spectrum.data(), work.delayed.data(), work.inverse.data(),
                        work.sway.data(),          work.observe.data(), nullptr};
  run.loop_gradient(constants(observation), loop_parameters(c), state,
                    {work.sway_spectrum.data(), work.loop_spectrum.data(), sums.data()});
  std::fill(work.sway_spectrum.begin() + 2 * frequencies_ * lanes, work.sway_spectrum.end(), 0.0);
  bins_fft_.inverse_lanes(work.loop_spectrum, work.by_passed, work.fft_work, isa_);
  run.join_gradient(bins_, work.by_passed.data(), work.by_halves.data());
  run.dead_band_gradient(halves(), dead_band_values(c, work),
                         {work.by_halves.data(), work.by_fine.data(), by_gain.data(), by_theta.data()});
  run.refine_gradient(bins_ + 1, work.by_fine.data(), work.by_velocity.data());
  noise_.gradient(work.by_velocity.data(), gradient.data(), work.noise_work.data(), isa_);

  const auto noises = static_cast<std::size_t>(noise_.size());
  const double back = 0.5 * padded_bins_;  // of the inverse transform, and of the pairs of frequencies
  std::array<double, lanes> coefficient_squares, by_noise, of_prior;
  for (std::size_t l = 0; l < lanes; ++l) {
    of_prior[l] = 1.0 / (c.radius[l] * c.radius[l]);
    by_noise[l] = -back * c.noise_gain[l] / (c.noise_rad[l] * c.noise_rad[l]);
  }
  run.squares(noise_.size(), x.data(), coefficient_squares.data());
  run.with_prior(noise_.size(), by_noise.data(), of_prior.data(), x.data(), gradient.data());
  for (std::size_t l = 0; l < lanes; ++l) {
    const auto global = [&](std::size_t i) -> double& { return gradient[(noises + i) * lanes + l]; };
    const auto coordinate = [&](std::size_t i) { return x[(noises + i) * lanes + l]; };
    const double precision = 1.0 / (c.noise_rad[l] * c.noise_rad[l]);
    const double count = static_cast<double>(noises);
    double value = 0.5 * precision * squares[l] + blocks_ * decid::log(c.noise_rad[l]) +
                   0.5 * coefficient_squares[l] * of_prior[l] + count * decid::log(c.radius[l]);
    for (std::size_t i = 0; i < globals; ++i) {
      value += 0.5 * coordinate(i) * coordinate(i);
      global(i) = coordinate(i);
    }
    potential[l] = value;
    const auto add = [&](std::size_t i, double by_value) {
      global(i) = std::fma(-precision * by_value, c.by_coordinate[i][l], global(i));
    };
    const auto sum = [&](std::size_t i) { return sums[i * lanes + l]; };
    add(sim::Kp, sum(0));
    add(sim::Kd, sum(1));
    add(sim::Kp_pass, sum(2));
    add(sim::Kd_pass, sum(3));
    add(sim::Delay, sum(4));
    add(start, sum(5));
    add(gain, sum(6));
    add(sim::Theta, back * by_theta[l]);
    add(sim::Nv, back * by_gain[l] * c.by_nv[l]);
    const double nv = c.value[sim::Nv][l];
    global(sim::Nv) += (count - coefficient_squares[l] * of_prior[l]) * nv * of_prior[l] * c.by_coordinate[sim::Nv][l];
    global(sensor_noise) += (blocks_ - precision * squares[l]) * c.by_coordinate[sensor_noise][l];
  }
}

void Density::model(const Observation& observation, std::span<const double> x, std::span<double> sway_rad,
                    std::span<double> residual_rad, Workspace& work) const {
  check(observation, x, sway_rad.size() + residual_rad.size(), 2 * static_cast<std::size_t>(blocks_) * lanes);
  const Chains c = chains(x, {});
  std::array<double, lanes> squares;
  forward(observation, x, c, work, squares.data());
  kernels(isa_).scale(blocks_, work.modelled.data(), undamp_.data(), sway_rad.data());
  std::copy_n(work.residual.begin(), residual_rad.size(), residual_rad.begin());
}

}  // namespace decid::posterior
