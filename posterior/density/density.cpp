// The posterior density of a recorded trial: see density.hpp.
#include "posterior/density/density.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "base/text.hpp"
#include "posterior/density/elementary.hpp"
#include "posterior/sampling/detail/chains.hpp"
#include "sim/simulate.hpp"

namespace decid::posterior {
namespace {

using sim::Complex;

constexpr double evidence_hz = 2.5;  // of the coefficients that the likelihood uses
constexpr double full_hz = 2.6, top_hz = max_noise_hz, block_ms = 100.0;
constexpr double whole_damping = 10.0;  // c times the transforms' length: wrapped values decay by e^-10
constexpr int spare_blocks = 40;        // of the transforms, in addition to the trial: more than the latest start
constexpr int min_blocks = 20;

/// Returns the begin of a bin, -bin_steps < step <= 0, such that the platform's velocity changes between the halves of
/// bins; nothing if it changes elsewhere too.
std::optional<int> find_first_step(const sim::Stimulus& stimulus, int bin_steps) {
  const int part = bin_steps % 2 == 0 ? bin_steps / 2 : bin_steps;
  int place = -1;
  for (std::size_t i = 1; i < stimulus.rate_rad_s.size(); ++i) {
    if (stimulus.rate_rad_s[i] == stimulus.rate_rad_s[i - 1]) continue;
    const int here = static_cast<int>(i) * stimulus.interval_steps % part;
    if (place >= 0 && here != place) return {};
    place = here;
  }
  return place <= 0 ? 0 : place - part;
}

/// Returns the samples per block, for blocks of about 100 ms: by up to a fifth more or less if the platform's velocity
/// then changes between the halves of bins.
int samples_per_block(const sim::Experiment& experiment) {
  const int steps = experiment.steps_per_sample(),
            usual = std::max(1, static_cast<int>(std::floor(block_ms / steps + 0.5)));
  const sim::Stimulus stimulus = sim::make_stimulus(experiment);
  const int all = experiment.samples();
  for (int other = 0; other <= usual / 5; ++other)
    for (const int samples : {usual - other, usual + other})
      if (NoiseSpectrum::fast_blocks(all / samples) >= min_blocks && find_first_step(stimulus, samples * steps))
        return samples;
  return usual;
}

/// Returns z = exp(s T) at frequency k, T one step.
Complex step_turn(double damping, long long k, long long steps) {
  const auto [sin, cos] = sincos_of_turn(k, steps);
  const double size = decid::exp(damping * sim::integration_step_s);
  return {size * cos, size * sin};
}

/// Returns the weight of a frequency: 1, then down to 0 with all derivatives. A sharp edge would ring through the whole
/// trial, and undoing the damping would amplify the ringing.
double frequency_weight(double hz) {
  const double u = (hz - full_hz) / (top_hz - full_hz);
  if (u <= 0.0) return 1.0;
  if (u >= 1.0) return 0.0;
  return 1.0 / (1.0 + decid::exp(std::clamp(1.0 / (1.0 - u) - 1.0 / u, -700.0, 700.0)));
}

/// Throws Error for noise that the posterior does not model.
void check_noise(const sim::Protocol& protocol, const NoiseBasis& basis) {
  const sim::VestibularNoise& noise = protocol.noise.vestibular;
  if (!(noise.scale_deg > 0.0)) return;
  const std::string where = "protocol " + protocol.name + ", vestibular_noise";
  if (noise.high_hz > max_noise_hz)
    throw Error(Code::not_supported, where, format("has frequencies up to %g Hz", noise.high_hz),
                format("give high_hz of %g or less; the posterior has no faster noise", max_noise_hz));
  if (noise.low_hz == noise.high_hz)
    throw Error(Code::setting_out_of_range, where, "has a single frequency",
                "give low_hz below high_hz; the posterior models the noise as a band");
  if (basis.size() == 0)
    throw Error(Code::setting_out_of_range, where, format("ends at %g Hz", noise.high_hz),
                format("give high_hz of %.2g or more", 0.5 / basis.period_s()));
}

/// Returns both ends of the least-squares line through `length` values.
template <class Value>
std::pair<double, double> line_through(const Value& value_at, int from, int length) {
  double mean = 0.0, slope = 0.0, squares = 0.0;
  for (int j = 0; j < length; ++j) {
    const double place = j - 0.5 * (length - 1);
    mean += value_at(from + j) / length;
    slope += place * value_at(from + j);
    squares += place * place;
  }
  slope = length > 1 ? slope / squares : 0.0;
  return {mean - 0.5 * length * slope, mean + 0.5 * length * slope};
}

}  // namespace

const sim::Protocol& require_family(const sim::Protocol& protocol) {
  protocol.validate();
  const sim::Family& family = protocol.family();
  if (family.terms.empty())
    throw Error(Code::not_supported, "protocol " + protocol.name,
                "its body model '" + protocol.experiment.body_model->name + "' is not a servo behind a dead band",
                "use a protocol of another controller");
  for (const sim::Coefficient alone : {sim::Coefficient::nv, sim::Coefficient::theta, sim::Coefficient::delay}) {
    for (const sim::Family::Term& term : family.terms) {
      if (term.coefficient != alone) continue;
      const auto count = std::ranges::count_if(family.terms, [&](const sim::Family::Term& other) {
        return other.coefficient == alone || other.parameter == term.parameter;
      });
      if (count != 1 || term.factor != 1.0 || family.constant[alone] != 0.0)
        throw Error(Code::not_supported, "body model " + protocol.experiment.body_model->name,
                    "its noise, threshold or delay is not a parameter of its own", "give each its own parameter");
    }
  }
  return protocol;
}

Density::Density(const sim::Protocol& protocol, const Priors& priors, Isa isa)
    : protocol_(require_family(protocol)),
      priors_(require_valid(priors)),
      ranges_(ranges_for(priors, protocol.ranges())),
      isa_(isa),
      unit_gains_(protocol.family().has_unit_gains()),
      block_samples_(samples_per_block(protocol.experiment)),
      bin_steps_(block_samples_ * protocol.experiment.steps_per_sample()),
      blocks_(NoiseSpectrum::fast_blocks(protocol.samples() / block_samples_)),
      lead_blocks_(static_cast<int>(std::ceil(
          priors.standing_s / (block_samples_ * protocol.experiment.steps_per_sample() * sim::integration_step_s)))),
      lead_steps_(lead_blocks_ * block_samples_ * protocol.experiment.steps_per_sample()),
      first_step_(0),
      bins_(0),
      edges_(0),
      padded_blocks_(sim::smooth_length(lead_blocks_ + protocol.samples() / block_samples_ + spare_blocks)),
      frequencies_(0),
      damping_(0.0),
      noise_(protocol, bin_steps_, (lead_steps_ + protocol.experiment.steps()) / bin_steps_ + 8,
             protocol.experiment.steps() / bin_steps_ + 8, top_hz),
      fft_(padded_blocks_),
      spectrum_(blocks_, block_samples_ * protocol.experiment.steps_per_sample() * sim::integration_step_s, evidence_hz,
                priors.drift_hz) {
  for (const sim::ParameterInfo& info : ranges_)
    quantiles_.push_back(make_quantile(priors, info.name, info.low, info.range()));
  if (blocks_ < min_blocks) {
    throw Error(Code::setting_out_of_range, "protocol " + protocol.name, format("lasts %g s", protocol.duration_s()),
                format("give a protocol of at least %g s", min_blocks * block_s()));
  }
  check_noise(protocol, noise_);
  const sim::Experiment& experiment = protocol.experiment;
  const int block_steps = block_samples_ * experiment.steps_per_sample();
  const double block_s = block_steps * sim::integration_step_s, step_s = sim::integration_step_s;
  const double padded_s = padded_blocks_ * block_s;
  const long long padded_steps = static_cast<long long>(padded_blocks_) * block_steps;
  damping_ = whole_damping / padded_s;
  frequencies_ = std::min(static_cast<int>(top_hz * padded_s), padded_blocks_ / 2);

  const sim::Stimulus stimulus = sim::make_stimulus(experiment);
  // Steps count from the begin of the standing.
  const int steps = lead_steps_ + experiment.steps();
  first_step_ = find_first_step(stimulus, bin_steps_).value_or(0);
  bins_ = (steps - first_step_ + bin_steps_ - 1) / bin_steps_ + 5;
  edges_ = (experiment.steps() - first_step_) / bin_steps_ + 1;
  const int last_step = experiment.steps() - 1,
            cycle = static_cast<int>(std::floor(experiment.cycle_s() * sim::steps_per_second + 0.5));
  const bool moved = priors.moved_before && experiment.lead_in_s() == 0.0;
  const auto rate_at = [&](int counted) {
    int step = counted - lead_steps_;
    if (step < 0 && !moved) return 0.0;
    while (step < 0) step += cycle;
    return stimulus.rate_at(std::min(step, last_step));
  };
  for (int half = 0; half < 2 * bins_; ++half) {
    const int bin_from = first_step_ + half / 2 * bin_steps_, first = bin_steps_ / 2;
    const int from = bin_from + half % 2 * first, count = half % 2 == 0 ? first : bin_steps_ - first;
    const int length = std::max(1, count);  // a bin of one step serves as both halves
    const auto [low, high] = line_through(rate_at, from, length);
    rate_low_.push_back(low);
    rate_high_.push_back(high);
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
    if (!unit_gains_) {
      put(derivative_, (z - 1.0) / step_s);
      put(slow_response_, quotient(step_s, z - (1.0 - step_s / family().slow_time_s)));
      put(torque_response_, quotient(step_s / mgh, z * (z - (1.0 - step_s / family().torque_time_s))));
    }
    Complex hold = 0.0, power = 1.0;
    const Complex step_back = quotient(1.0, z);
    for (int j = 0; j < bin_steps_; ++j, power *= step_back) hold += power;
    const auto [sin, cos] = sincos_of_turn(static_cast<long long>(k) * first_step_, padded_steps);
    put(hold_, hold * Complex(cos, -sin));
    Complex sample = 1.0, mean = 0.0, turn = 1.0;
    for (int j = 0; j < experiment.steps_per_sample(); ++j) turn *= z;
    for (int j = 0; j < block_samples_; ++j, sample *= turn) mean += sample;
    put(observe_, mean * (frequency_weight(k / padded_s) / block_samples_));
    put(platform_, spectrum[static_cast<std::size_t>(k)]);
  }
  set_unbinned();
  for (int block = lead_blocks_; block < lead_blocks_ + blocks_; ++block)
    undamp_.push_back(decid::exp(damping_ * block_s * block) * padded_blocks_ / static_cast<double>(padded_steps));
}

// The velocity passes the dead band less at most theta. Bins are exact for a straight line in each half only,
// and their error grows with the velocity. So the platform's part of it is taken from its steps, as if all of it
// passed: what remains grows with theta.
void Density::set_unbinned() {
  const auto in_lanes = [](int count) { return AlignedVector<double>(static_cast<std::size_t>(count) * lanes, 0.0); };
  AlignedVector<double> halves = in_lanes(2 * bins_), bins = in_lanes(padded_blocks_),
                        spectrum = in_lanes(2 * fft_.bins()), work = in_lanes(2 * fft_.work_length());
  for (std::size_t half = 0; half < weight_.size(); ++half)
    std::fill_n(halves.begin() + static_cast<std::ptrdiff_t>(half * lanes), lanes,
                weight_[half] * 0.5 * (rate_low_[half] + rate_high_[half]));
  kernels(isa_).join(bins_, halves.data(), bins.data());
  fft_.forward_lanes(bins, spectrum, work, isa_);
  for (std::size_t k = 0; k < static_cast<std::size_t>(frequencies_); ++k) {
    const Complex of_bins(spectrum[2 * k * lanes], spectrum[(2 * k + 1) * lanes]);
    put(unbinned_, Complex(platform_[2 * k], platform_[2 * k + 1]) - of_bins * Complex(hold_[2 * k], hold_[2 * k + 1]));
  }
}

Density::Transforms Density::transforms() const {
  return {fft_.length(), noise_.transform_length(), noise_.transforms()};
}

Density::Workspace::Workspace(const Density& d) {
  const auto of = [](int count) { return static_cast<std::size_t>(count) * lanes; };
  for (auto* values : {&velocity, &by_velocity}) values->assign(of(d.noise_.edges()), 0.0);
  for (auto* values : {&fine, &by_fine}) values->assign(of(2 * d.bins_ + 1), 0.0);
  for (auto* values : {&halves, &by_halves, &by_low, &by_high, &by_theta}) values->assign(of(2 * d.bins_), 0.0);
  for (auto* values : {&passed, &by_passed}) values->assign(of(d.padded_blocks_), 0.0);
  for (auto* values : {&bins_spectrum, &loop_spectrum, &sway_spectrum}) values->assign(of(2 * d.fft_.bins()), 0.0);
  for (auto* values : {&delayed, &inverse, &sway, &observe, &response}) values->assign(of(2 * d.frequencies_), 0.0);
  modelled.assign(of(d.padded_blocks_), 0.0);
  residual.assign(of(d.padded_blocks_), 0.0);
  unfolded.assign(of(d.blocks_), 0.0);
  noise = d.spectrum_.workspace();
  fft_work.assign(of(2 * d.fft_.work_length()), 0.0);
  noise_work.assign(d.noise_.work_size(), 0.0);
}

LoopParameters Density::loop_parameters(const Chains& c) const {
  using enum sim::Coefficient;
  return {.kp = c[kp].data(),
          .kd = c[kd].data(),
          .kp_pass = c[kp_pass].data(),
          .kd_pass = c[kd_pass].data(),
          .gain = c.value[place(Quantity::gain)].data(),
          .delay_first = c.delay_first[0].data(),
          .delay_turn = c.delay_turn[0].data(),
          .start_first = c.start_first[0].data(),
          .start_turn = c.start_turn[0].data(),
          .position = c[position].data(),
          .tilt = c[tilt].data(),
          .gravity = c[gravity].data(),
          .slow = c[slow].data(),
          .torque = c[torque].data()};
}

DeadBandBins Density::halves() const {
  return {2 * bins_, rate_low_.data(), rate_high_.data(), weight_.data()};
}

DeadBandValues Density::dead_band_values(const Chains& c, Workspace& work) const {
  return {work.fine.data(),    c.noise_gain.data(), c[sim::Coefficient::theta].data(),
          work.halves.data(),  work.by_low.data(),  work.by_high.data(),
          work.by_theta.data()};
}

LoopConstants Density::constants(const Observation& observation) const {
  return {frequencies_,          s_.data(),
          sum_.data(),           rate_.data(),
          body_.data(),          hold_.data(),
          observe_.data(),       platform_.data(),
          unbinned_.data(),      observation.torque.data(),
          2.0 / padded_blocks_,  derivative_.data(),
          slow_response_.data(), torque_response_.data()};
}

void Density::check(const Observation& observation, std::span<const double> x, std::size_t results,
                    std::size_t expected) const {
  const auto all = static_cast<std::size_t>(size()) * lanes;
  if (x.size() == all && results == expected && observation.sway.size() == static_cast<std::size_t>(blocks_) &&
      observation.torque.size() == s_.size())
    return;
  throw Error(Code::size_mismatch, "posterior",
              format("got %zu coordinates and space for %zu results", x.size(), results),
              format("give %zu and %zu, and an observation of this density", all, expected));
}

void Density::to_blocks(Workspace& work) const {
  fft_.inverse_lanes(work.sway_spectrum, work.modelled, work.fft_work, isa_);
}

std::array<double, lanes> Density::forward(const Observation& observation, std::span<const double> x, const Chains& c,
                                           Workspace& work) const {
  const Kernels& run = kernels(isa_);
  noise_.synthesize(x.data(), work.velocity.data(), work.noise_work.data(), isa_);
  run.refine(bins_ + 1, work.velocity.data(), work.fine.data());
  run.dead_band(halves(), dead_band_values(c, work));
  run.join(bins_, work.halves.data(), work.passed.data());
  fft_.forward_lanes(work.passed, work.bins_spectrum, work.fft_work, isa_);
  (unit_gains_ ? run.loop : run.family_loop)(constants(observation), loop_parameters(c),
                                             {work.bins_spectrum.data(), work.delayed.data(), work.inverse.data(),
                                              work.sway.data(), work.observe.data(), work.sway_spectrum.data()});
  to_blocks(work);
  run.unfold(blocks_, observation.sway.data(), trial_blocks(work.modelled), undamp_.data(), work.unfolded.data());
  spectrum_.clear(observation.missing, work.unfolded);
  std::array<double, lanes> misfit = spectrum_.misfit(c.levels, work.unfolded, work.noise, isa_);
  spectrum_.leave_out(observation.missing, work.noise, misfit, isa_);
  return misfit;
}

std::array<double, sim::Coefficients::count> Density::by_coefficients(std::span<const double> sums, double by_nv,
                                                                      double by_theta, std::size_t l) const {
  using enum sim::Coefficient;
  std::array<double, sim::Coefficients::count> by{};
  const auto set = [&](sim::Coefficient c, double value) { by[static_cast<std::size_t>(c)] = value; };
  constexpr std::array<std::pair<sim::Coefficient, std::size_t>, 10> of_loop{{{kp, 0},
                                                                              {kd, 1},
                                                                              {kp_pass, 2},
                                                                              {kd_pass, 3},
                                                                              {delay, 4},
                                                                              {position, 7},
                                                                              {tilt, 8},
                                                                              {gravity, 9},
                                                                              {slow, 10},
                                                                              {torque, 11}}};
  for (const auto& [coefficient, sum] : of_loop) set(coefficient, sums[sum * lanes + l]);
  set(nv, by_nv);
  set(theta, by_theta);
  return by;
}

void Density::evaluate(const Observation& observation, std::span<const double> x, std::span<double> gradient,
                       std::span<double> potential, Workspace& work, std::optional<double> fixed_noise_deg) const {
  check(observation, x, gradient.size() + potential.size(), x.size() + lanes);
  const Kernels& run = kernels(isa_);
  const Chains c = chains(x, fixed_noise_deg);
  std::array<double, lanes> d_gain, d_theta;
  const std::array<double, lanes> misfit = forward(observation, x, c, work);

  NoiseSpectrum::LevelGradient d_levels = spectrum_.gradient(c.levels, work.unfolded, work.noise, isa_);
  spectrum_.add_gradient(observation.missing, c.levels, work.noise, d_levels, isa_);
  spectrum_.clear(observation.missing, work.unfolded);
  std::fill(work.residual.begin(), work.residual.end(), 0.0);
  run.fold(blocks_, work.unfolded.data(), undamp_.data(),
           work.residual.data() + static_cast<std::ptrdiff_t>(lead_blocks_) * lanes);
  fft_.forward_lanes(work.residual, work.sway_spectrum, work.fft_work, isa_);
  std::array<double, loop_sums * lanes> sums{};
  const LoopState state{work.bins_spectrum.data(), work.delayed.data(), work.inverse.data(),
                        work.sway.data(),          work.observe.data(), nullptr};
  (unit_gains_ ? run.loop_gradient : run.family_loop_gradient)(
      constants(observation), loop_parameters(c), state,
      {work.sway_spectrum.data(), work.loop_spectrum.data(), sums.data()});
  std::fill(work.sway_spectrum.begin() + 2 * frequencies_ * lanes, work.sway_spectrum.end(), 0.0);
  fft_.inverse_lanes(work.loop_spectrum, work.by_passed, work.fft_work, isa_);
  run.join_gradient(bins_, work.by_passed.data(), work.by_halves.data());
  run.dead_band_gradient(halves(), dead_band_values(c, work),
                         {work.by_halves.data(), work.by_fine.data(), d_gain.data(), d_theta.data()});
  run.refine_gradient(bins_ + 1, work.by_fine.data(), work.by_velocity.data());
  noise_.gradient(work.by_velocity.data(), gradient.data(), work.noise_work.data(), isa_);

  const auto noises = static_cast<std::size_t>(noise_.size()), count_of_globals = static_cast<std::size_t>(globals());
  const double back = 0.5 * padded_blocks_;  // of the inverse transform, and of the pairs of frequencies
  std::array<double, lanes> coefficient_squares, factor, of_prior;
  for (std::size_t l = 0; l < lanes; ++l) {
    of_prior[l] = 1.0 / (c.radius[l] * c.radius[l]);
    factor[l] = -back * c.noise_gain[l];
  }
  run.squares(noise_.size(), x.data(), coefficient_squares.data());
  run.with_prior(noise_.size(), factor.data(), of_prior.data(), x.data(), gradient.data());
  for (std::size_t l = 0; l < lanes; ++l) {
    const auto global = [&](std::size_t i) -> double& { return gradient[(noises + i) * lanes + l]; };
    const auto of = [&](int quantity) -> double& { return global(place(quantity)); };
    const auto coordinate = [&](std::size_t i) { return x[(noises + i) * lanes + l]; };
    const double count = static_cast<double>(noises);
    double value = misfit[l] + 0.5 * coefficient_squares[l] * of_prior[l] + count * decid::log(c.radius[l]);
    for (std::size_t i = 0; i < count_of_globals; ++i) {
      value += 0.5 * coordinate(i) * coordinate(i);
      global(i) = coordinate(i);
    }
    potential[l] = value;
    // Derivatives by the modelled blocks, with the residual's sign.
    const auto add = [&](std::size_t i, double derivative) {
      global(i) = std::fma(-derivative, c.d_coordinate[i][l], global(i));
    };
    add(place(start), sums[5 * lanes + l]);
    add(place(gain), sums[6 * lanes + l]);
    const std::array<double, sim::Coefficients::count> by_coefficient =
        by_coefficients(sums, back * d_gain[l] * c.d_nv[l], back * d_theta[l], l);
    std::array<double, sim::Parameters::max_parameters> by_parameter{};
    const double nv = c[sim::Coefficient::nv][l];
    for (const sim::Family::Term& term : family().terms)
      by_parameter[term.parameter] += term.factor * by_coefficient[static_cast<std::size_t>(term.coefficient)];
    for (std::size_t i = 0; i < quantiles_.size(); ++i) add(i, by_parameter[i]);
    for (const sim::Family::Term& term : family().terms) {
      if (term.coefficient != sim::Coefficient::nv) continue;
      global(term.parameter) +=
          (count - coefficient_squares[l] * of_prior[l]) * nv * of_prior[l] * c.d_coordinate[term.parameter][l];
    }
    const double d_slow = d_levels.slow[l] * c.levels.slow[l];
    of(sensor_noise) += d_levels.white[l] * c.levels.white[l] * c.d_white[l] + d_slow * c.d_slow_white[l];
    of(slow_noise) += d_slow * c.d_slow[l];
    of(slow_memory) += (d_slow + 2.0 * d_levels.memory[l]) * c.d_memory[l];
  }
}

void Density::model(const Observation& observation, std::span<const double> x, std::span<double> sway_rad,
                    std::span<double> residual_rad, Workspace& work) const {
  check(observation, x, sway_rad.size() + residual_rad.size(), 2 * static_cast<std::size_t>(blocks_) * lanes);
  const Kernels& run = kernels(isa_);
  forward(observation, x, chains(x, {}), work);
  run.scale(blocks_, trial_blocks(work.modelled), undamp_.data(), sway_rad.data());
  const double root = std::sqrt(static_cast<double>(blocks_));
  for (std::size_t m = 0; m < static_cast<std::size_t>(blocks_); ++m) {
    const double place = (static_cast<double>(m) + 0.5) / blocks_ - 0.5;
    const double recorded_line = observation.level_rad + observation.slope_rad * place * blocks_;
    for (std::size_t l = 0; l < lanes; ++l) {
      double& sway = sway_rad[m * lanes + l];
      sway += work.noise.coefficient[l] / root + work.noise.line[l] * place;
      residual_rad[m * lanes + l] = observation.sway[m] - sway;
      sway += recorded_line;
    }
  }
  for (const int m : observation.missing.blocks)
    std::ranges::fill(residual_rad.subspan(static_cast<std::size_t>(m) * lanes, lanes), 0.0);
}

void Density::leave_block_out(const Observation& observation, std::span<const double> x, std::span<double> log_density,
                              Workspace& work) const {
  check(observation, x, log_density.size(), static_cast<std::size_t>(blocks_) * lanes);
  forward(observation, x, chains(x, {}), work);
  spectrum_.leave_block_out(observation.missing, log_density, work.noise, isa_);
  const double per_deg = decid::log(sim::rad_per_deg);
  for (double& value : log_density) value += per_deg;
  for (const int m : observation.missing.blocks)
    std::ranges::fill(log_density.subspan(static_cast<std::size_t>(m) * lanes, lanes), 0.0);
}

}  // namespace decid::posterior
