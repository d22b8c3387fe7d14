// The construction of a density: lengths of blocks and bins, the platform's velocity in bins and as a transform, and
// the transfer functions of the loop. See density.hpp.
#include <algorithm>
#include <cmath>
#include <complex>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/text.hpp"
#include "posterior/density/density.hpp"
#include "posterior/density/elementary.hpp"
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
int samples_per_block(const sim::Experiment& experiment, const sim::Stimulus& stimulus) {
  const int steps = experiment.steps_per_sample(),
            usual = std::max(1, static_cast<int>(std::floor(block_ms / steps + 0.5)));
  const int all = experiment.samples();
  for (int other = 0; other <= usual / 5; ++other)
    for (const int samples : {usual - other, usual + other})
      if (NoiseSpectrum::fast_blocks(all / samples) >= min_blocks && find_first_step(stimulus, samples * steps))
        return samples;
  return usual;
}

/// Returns the blocks of the protocol. Throws Error for too few.
int count_blocks(const sim::Protocol& protocol, int block_samples) {
  const int all = protocol.samples() / block_samples, blocks = all > 0 ? NoiseSpectrum::fast_blocks(all) : 0;
  if (blocks >= min_blocks) return blocks;
  throw Error(
      Code::setting_out_of_range, "protocol " + protocol.name, format("lasts %g s", protocol.duration_s()),
      format("give a protocol of at least %g s", min_blocks * block_samples / protocol.experiment.sample_rate_hz));
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

/// The platform's velocity in steps that count from the begin of the standing.
class Density::PlatformRate {
 public:
  /// Refers to the stimulus. moved_before: the platform moved, as in its cycles, before a trial without a lead-in.
  PlatformRate(const sim::Experiment& experiment, const sim::Stimulus& stimulus, int lead_steps, bool moved_before)
      : stimulus_(stimulus),
        lead_steps_(lead_steps),
        last_step_(experiment.steps() - 1),
        cycle_(static_cast<int>(std::floor(experiment.cycle_s() * sim::steps_per_second + 0.5))),
        moved_(moved_before && experiment.lead_in_s() == 0.0) {}
  /// Returns the velocity of a step, rad/s; after the trial that of its last step.
  double operator()(int counted) const {
    int step = counted - lead_steps_;
    if (step < 0 && !moved_) return 0.0;
    while (step < 0) step += cycle_;
    return stimulus_.rate_at(std::min(step, last_step_));
  }

 private:
  const sim::Stimulus& stimulus_;
  int lead_steps_, last_step_, cycle_;
  bool moved_;
};

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
    : Density(protocol, priors, isa, sim::make_stimulus(require_family(protocol).experiment)) {}

Density::Density(const sim::Protocol& protocol, const Priors& priors, Isa isa, const sim::Stimulus& stimulus)
    : protocol_(protocol),
      priors_(require_valid(priors)),
      ranges_(ranges_for(priors, protocol.ranges())),
      isa_(isa),
      unit_gains_(protocol.family().has_unit_gains()),
      block_samples_(samples_per_block(protocol.experiment, stimulus)),
      bin_steps_(block_samples_ * protocol.experiment.steps_per_sample()),
      blocks_(count_blocks(protocol, block_samples_)),
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
  check_noise(protocol, noise_);
  const double padded_s = this->padded_s(), block_length_s = bin_s();
  damping_ = whole_damping / padded_s;
  frequencies_ = std::min(static_cast<int>(top_hz * padded_s), padded_blocks_ / 2);
  const int steps = lead_steps_ + protocol.experiment.steps();
  first_step_ = find_first_step(stimulus, bin_steps_).value_or(0);
  bins_ = (steps - first_step_ + bin_steps_ - 1) / bin_steps_ + 5;
  edges_ = (protocol.experiment.steps() - first_step_) / bin_steps_ + 1;

  const PlatformRate rate_at(protocol.experiment, stimulus, lead_steps_, priors.moved_before || protocol.moved_before);
  set_bins(rate_at);
  set_platform(rate_at);
  set_loop();
  set_unbinned();
  for (int block = lead_blocks_; block < lead_blocks_ + blocks_; ++block)
    undamp_.push_back(decid::exp(damping_ * block_length_s * block) * padded_blocks_ /
                      static_cast<double>(padded_steps()));
}

void Density::set_bins(const PlatformRate& rate_at) {
  for (int half = 0; half < 2 * bins_; ++half) {
    const int bin_from = first_step_ + half / 2 * bin_steps_, first = bin_steps_ / 2;
    const int from = bin_from + half % 2 * first, count = half % 2 == 0 ? first : bin_steps_ - first;
    const int length = std::max(1, count);  // a bin of one step serves as both halves
    const auto [low, high] = line_through(rate_at, from, length);
    rate_low_.push_back(low);
    rate_high_.push_back(high);
    const int here = std::clamp(from + length, 0, length);  // steps before the trial's start do not count
    weight_.push_back(decid::exp(-damping_ * sim::integration_step_s * bin_from) * here / length);
  }
}

void Density::set_platform(const PlatformRate& rate_at) {
  const sim::RealFft steps_fft(static_cast<int>(padded_steps()));
  std::vector<double> rates(static_cast<std::size_t>(padded_steps()), 0.0);
  const int steps = lead_steps_ + protocol_.experiment.steps();
  for (int step = 0; step < std::min<long long>(steps + bin_steps_ * 4, padded_steps()); ++step)
    rates[static_cast<std::size_t>(step)] = rate_at(step) * decid::exp(-damping_ * sim::integration_step_s * step);
  std::vector<Complex> spectrum(static_cast<std::size_t>(steps_fft.bins()));
  std::vector<Complex> work(static_cast<std::size_t>(steps_fft.work_length()));
  steps_fft.forward(rates, spectrum, work);
  for (int k = 0; k < frequencies_; ++k) put(platform_, spectrum[static_cast<std::size_t>(k)]);
}

void Density::set_loop() {
  const sim::Experiment& experiment = protocol_.experiment;
  const double padded_s = this->padded_s(), step_s = sim::integration_step_s;
  const double inertia = experiment.body.inertia_kgm2, mgh = experiment.body.mgh();
  for (int k = 0; k < frequencies_; ++k) {
    const Complex z = step_turn(damping_, k, padded_steps());
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
    const auto [sin, cos] = sincos_of_turn(static_cast<long long>(k) * first_step_, padded_steps());
    put(hold_, hold * Complex(cos, -sin));
    Complex sample = 1.0, mean = 0.0, turn = 1.0;
    for (int j = 0; j < experiment.steps_per_sample(); ++j) turn *= z;
    for (int j = 0; j < block_samples_; ++j, sample *= turn) mean += sample;
    put(observe_, mean * (frequency_weight(k / padded_s) / block_samples_));
  }
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

}  // namespace decid::posterior
