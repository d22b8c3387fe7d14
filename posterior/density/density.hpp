// The posterior density of everything unknown about a recorded trial: the seven parameters, the vestibular noise, the
// measurement noise, where the recording starts and how it is scaled; with its exact gradient, for `lanes` chains at
// once.
//
// The dead band acts on the platform's velocity plus noise, never on the body: a kink without memory, then a linear
// system. So the sway is the transform of what passes the dead band, in bins of some 50 ms with two straight halves and
// the first moment of their difference, times the transfer function of the simulator's own 1 ms steps. It is taken on
// the contour s = c + i w, c > 0: with the damped transform nothing wraps around. Sway is averaged to blocks of some
// 100 ms. What sin(a) lacks of a is a torque that the recorded sway gives.
//
// Start: nobody stands still at exactly 0 when a recording begins. The model begins at rest `standing_s` earlier, with
// vestibular noise from then on, so the state at the first sample has the distribution that standing has.
//
// Coordinates, all with a standard normal prior except the vestibular noise's: a parameter is its prior's quantile at
// Phi(x), so uniform in its range unless the priors say otherwise; logarithms of the levels of the noises and of the
// gain; the start as parameters; coefficients w of the vestibular noise, which has the coefficients z = w / r,
// r = sqrt(Nv^2 + 0.05^2), so w ~ N(0, r^2): what is seen of the noise is z Nv, and so w does not change with Nv where
// that is not tiny.
//
// Measurement noise: white, plus slow noise with the spectrum of an Ornstein-Uhlenbeck process, plus an offset and a
// straight line with wide priors, which are integrated out. The cosine transform of the blocks makes all of these
// independent from frequency to frequency (spectrum.hpp); frequencies above 2.5 Hz are not looked at, where little of
// the sway is and where laboratories filter. The model's own error is taken for white noise: 0.0005 degrees in the mean
// of a block.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "base/aligned.hpp"
#include "posterior/density/noise_basis.hpp"
#include "posterior/density/priors.hpp"
#include "posterior/density/spectrum.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::posterior {

/// A point in terms of what it means.
struct State {
  sim::Parameters parameters;
  double sensor_noise_deg = 0.0;
  double start_s = 0.0;
  double gain = 1.0;
  double slow_noise_deg = 0.0;
  double slow_memory_s = 1.0;
};

/// A recorded trial as the density needs it.
struct Observation {
  std::vector<double> sway;      ///< mean of each block of samples less the straight line, rad
  double level_rad = 0.0;        ///< the straight line of least squares through the blocks: its middle
  double slope_rad = 0.0;        ///< and what it gains from one block to the next
  AlignedVector<double> torque;  ///< transform of m g h (sin a - a), complex
  double noise_deg = 0.0;        ///< white noise of a sample with the power that the highest frequencies have
};

/// The protocol, if it is valid and its body is the one that posteriors are written for; else throws Error.
const sim::Protocol& of_single_pendulum(const sim::Protocol& protocol);

/// Immutable: one serves all threads, each with a Workspace of its own.
class Density {
 public:
  /// The coordinates behind those of the noise.
  enum Global {
    first_parameter = 0,
    sensor_noise = 7,
    start = 8,
    gain = 9,
    slow_noise = 10,
    slow_memory = 11,
    globals = 12
  };

  /// The last globals, the slow noise's, are found while chains warm up, and held while they draw: what is left to
  /// learn of them widens no interval, and chains mix far more slowly in them than in all others.
  static constexpr int held = 2;
  static constexpr bool is_held(std::size_t global) { return global + held >= globals; }

  /// Throws Error if the protocol is not valid, has fewer than 20 blocks of samples, noise of a single frequency or
  /// another body model than the single pendulum, and for priors out of their bounds.
  Density(const sim::Protocol& protocol, const Priors& priors, Isa isa = chosen_isa());

  const sim::Protocol& protocol() const noexcept { return protocol_; }
  /// Where parameters may lie: the priors' ranges, else those of the protocol's body.
  const sim::ParameterTable& ranges() const noexcept { return ranges_; }
  const Priors& priors() const noexcept { return priors_; }
  /// Coordinates: those of the noise, then `globals` more.
  int size() const noexcept { return noise_.size() + globals; }
  int noise_size() const noexcept { return noise_.size(); }
  int blocks() const noexcept { return blocks_; }
  double noise_period_s() const noexcept { return noise_.period_s(); }
  /// Lengths of the Fourier transforms, and how many of the noise an evaluation has either way.
  struct Transforms {
    int bins, blocks, noise, noise_count;
  };
  Transforms transforms() const;
  /// Whether a global is inferred, or known: start and gain may be.
  bool infers(Global global) const noexcept {
    return (global != start || priors_.start_s > 0.0) && (global != gain || priors_.gain > 0.0);
  }
  /// Where the first bin of the trial begins, at the protocol's start or just before.
  double first_bin_s() const noexcept { return first_step_ * sim::integration_step_s; }
  double bin_s() const noexcept { return bin_steps_ * sim::integration_step_s; }
  double block_s() const { return block_samples_ / protocol_.experiment.sample_rate_hz; }
  /// The white noise in the mean of a block: the sensor's, and the model's own error.
  double block_noise_rad(double sensor_noise_deg) const;
  /// Those of the bins within the trial: edge i is at first_bin_s() + i * bin_s().
  int edges() const { return (protocol_.experiment.steps() - first_step_) / bin_steps_ + 1; }
  Isa isa() const noexcept { return isa_; }

  /// sway_rad: the protocol's samples. Throws Error for another number of them.
  Observation observe(std::span<const float> sway_rad) const;

  /// The point that a chain's coordinates mean; x: size() values a chain.
  State state(std::span<const double> x, int chain) const;
  /// Sets a chain's coordinates but those of the noise; values outside of their ranges, or
  /// within a hundredth of their ends, go to that hundredth.
  void set(const State& state, std::span<double> x, int chain) const;
  /// The standard normal coordinate that a value of a global has; of a parameter outside of its range that of the
  /// range's hundredth.
  double prior_coordinate(int global, double value) const;
  /// Sets a chain's coordinates of the levels of the measurement noise.
  void set_noise(double sensor_noise_deg, double slow_noise_deg, std::span<double> x, int chain) const;

  class Workspace {
   public:
    explicit Workspace(const Density& density);

   private:
    friend class Density;
    AlignedVector<double> velocity, fine, by_fine, halves, by_halves, passed, by_low, by_high, by_theta, by_passed,
        by_velocity;
    AlignedVector<double> bins_spectrum, sway_spectrum, delayed, inverse, sway, observe, loop_spectrum, modelled,
        residual, unfolded, blocks_spectrum;
    NoiseWorkspace noise;
    AlignedVector<double> fft_work, noise_work, columns, products, noise_column, fine_column, response;
  };

  // These throw Error for spans of other sizes, and for the observation of another density.
  /// Minus the logarithm of the density of each chain, up to a constant, and its gradient; x, gradient: size() values a
  /// chain. fixed_noise_deg: the sensor's noise is this, and its coordinate has a standard normal prior: for a start
  /// that is annealed.
  void evaluate(const Observation& observation, std::span<const double> x, std::span<double> gradient,
                std::span<double> potential, Workspace& work, std::optional<double> fixed_noise_deg = {}) const;
  /// Minus the logarithm of the likelihood of each chain: without priors, up to a constant.
  void misfit(const Observation& observation, std::span<const double> x, std::span<double> misfit,
              Workspace& work) const;
  /// Sway of each chain as it is modelled, offset and straight line included: the means of blocks, rad, blocks() values
  /// a chain; and what the recording has besides.
  void model(const Observation& observation, std::span<const double> x, std::span<double> sway_rad,
             std::span<double> residual_rad, Workspace& work) const;
  /// log p of each block's mean, in degrees, given all other blocks and the chain's unknowns; blocks() values a chain.
  void leave_block_out(const Observation& observation, std::span<const double> x, std::span<double> log_density,
                       Workspace& work) const;
  /// What each chain's controller perceives: the velocity of its vestibular noise at the dead band, rad/s, and its
  /// estimate of the platform's tilt, which is the integral of what passes the dead band since the start, rad; edges()
  /// values a chain each.
  void perceive(std::span<const double> x, std::span<double> noise_rad_s, std::span<double> tilt_rad,
                Workspace& work) const;
  /// The information of each chain about its coordinates, at its point: J^t J / noise^2 (Gauss-Newton) and that of the
  /// prior. A lower triangle, row after row, triangle(size()) values a chain.
  void information(const Observation& observation, std::span<const double> x, std::span<double> matrices,
                   Workspace& work, std::optional<double> fixed_noise_deg = {}) const;

 private:
  struct Chains;  // what each chain's coordinates mean, chain by chain
  Chains chains(std::span<const double> x, std::optional<double> fixed_noise_deg) const;
  LoopParameters loop_parameters(const Chains& chains) const;
  DeadBandBins halves() const;
  DeadBandValues dead_band_values(const Chains& chains, Workspace& work) const;
  LoopConstants constants(const Observation& observation) const;
  void check(const Observation& observation, std::span<const double> x, std::size_t results,
             std::size_t expected) const;
  /// From the coordinates to the residual's cosine transform; returns minus the logarithm of the likelihood.
  std::array<double, lanes> forward(const Observation& observation, std::span<const double> x, const Chains& chains,
                                    Workspace& work) const;
  /// From a transform of the observed sway in work.sway_spectrum to blocks in work.modelled.
  void to_blocks(Workspace& work) const;
  /// The blocks of the trial among all that are modelled.
  const double* trial_of(const AlignedVector<double>& blocks) const {
    return blocks.data() + static_cast<std::ptrdiff_t>(lead_blocks_) * lanes;
  }
  /// The levels of a chain's measurement noise, by the three coordinates.
  void set_noise(Chains& chains, std::size_t chain, double white, double slow, double memory,
                 std::optional<double> fixed_noise_deg) const;
  /// Adds what is known of the levels of the measurement noise; after forward().
  void add_noise_information(const Chains& chains, const Workspace& work, std::span<double> matrices) const;
  double noise_of_highest(std::span<const double> sway) const;

  sim::Protocol protocol_;
  Priors priors_;
  sim::ParameterTable ranges_;
  Isa isa_;
  std::array<Quantile, 7> quantiles_;  // of the parameters
  int block_samples_, bin_steps_, blocks_;
  int lead_blocks_, lead_steps_;  // before the trial
  int first_step_, bins_, padded_bins_, padded_blocks_, frequencies_;
  double damping_;  // c, 1/s
  NoiseBasis noise_;
  sim::RealFft bins_fft_, blocks_fft_;
  NoiseSpectrum spectrum_;
  AlignedVector<double> rate_low_, rate_high_, weight_, undamp_;
  AlignedVector<double> s_, sum_, rate_, body_, hold_, observe_, platform_;
};

}  // namespace decid::posterior
