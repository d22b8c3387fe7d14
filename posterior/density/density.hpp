// The posterior density of all unknowns of a recorded trial: the parameters of the protocol's controller, any member of
// the family (sim/family.hpp), the vestibular noise, the measurement noise, the recording's start and its scale. Also
// its exact gradient, for `lanes` chains at once.
//
// The dead band acts on the platform's velocity plus noise, never on the body: a memoryless kink, then a linear system.
// The sway's transform is the transform of the velocity that passes the dead band, times the transfer function of the
// simulator's own 1 ms steps. Bins of some 100 ms hold the passed velocity as two straight halves and the first moment
// of their difference; what they lose of the platform's own velocity is added from its steps. The contour s = c + i w,
// c > 0, damps the transform, so that nothing wraps around. Sway is averaged to blocks of some 100 ms, between whose
// halves the platform's velocity changes where a length allows it. The difference between sin(a) and a is a torque
// computed from the recorded sway.
//
// Start: a standing body is never exactly at 0. The model begins at rest `standing_s` earlier, with vestibular noise
// from then on, so the state at the first sample has the distribution of standing.
//
// Coordinates, all with a standard normal prior except the vestibular noise's:
// - a parameter is its prior's quantile at Phi(x), so uniform in its range unless the priors state otherwise;
// - logarithms of the noise levels and of the gain;
// - the start, like a parameter;
// - coefficients w of the vestibular noise, whose coefficients are z = w / r with r = sqrt(Nv^2 + 0.05^2), so w ~ N(0,
// r^2). The data determine z Nv, so w does not change with Nv unless Nv is tiny.
//
// Measurement noise: white noise, slow noise with the spectrum of an Ornstein-Uhlenbeck process, and an offset and a
// straight line with wide priors, which are integrated out. The cosine transform of the blocks makes all of these
// independent between frequencies (spectrum.hpp). The likelihood ignores frequencies above 2.5 Hz, where sway has
// little power and laboratories filter. The model's own error counts as white noise: 0.0005 degrees in the mean of a
// block.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "base/aligned.hpp"
#include "base/sample_range.hpp"
#include "posterior/density/noise_basis.hpp"
#include "posterior/density/priors.hpp"
#include "posterior/density/spectrum.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::posterior {

/// A point as physical quantities.
struct State {
  sim::Parameters parameters;     ///< SI units, in the table's order
  double sensor_noise_deg = 0.0;  ///< standard deviation of the white noise of a sample
  double start_s = 0.0;           ///< the protocol's time at the first sample: above 0 if the recording begins late
  double gain = 1.0;              ///< recorded over true sway
  double slow_noise_deg = 0.0;    ///< standard deviation of the slow noise
  double slow_memory_s = 1.0;     ///< its correlation falls to 1/e in this time
};

/// A recorded trial in the density's form.
struct Observation {
  std::vector<double> sway;      ///< mean of each block of samples minus the straight line, rad
  double level_rad = 0.0;        ///< least-squares line through the blocks: its middle
  double slope_rad = 0.0;        ///< and its increase from one block to the next
  AlignedVector<double> torque;  ///< transform of m g h (sin a - a), complex
  MissingBlocks missing;         ///< that were not recorded
  double noise_deg = 0.0;        ///< white noise per sample with the power of the highest frequencies
};

/// The longest time in all blocks that gaps touch, and its limit as a fraction of the trial. The time of a fit grows
/// with its square.
inline constexpr double max_missing_s = 20.0, max_missing_fraction = 0.5;

/// The highest frequency of vestibular noise that the density can have. The transforms of the sway end there; the noise
/// above would still smooth the dead band.
inline constexpr double max_noise_hz = 4.4;

/// Returns the protocol. Throws Error if it is invalid, or if its body model is not a member of the family whose
/// vestibular noise, threshold and delay each are one parameter or a constant.
const sim::Protocol& require_family(const sim::Protocol& protocol);

/// The density. Immutable: all threads may share it, each with its own Workspace.
class Density {
 public:
  /// The quantities that are inferred in addition to the noise: the controller's parameters by their index in its
  /// table, then these. Their coordinates, the globals, stand after the noise's, in this order: see place().
  enum Quantity : int { sensor_noise = sim::Parameters::max_parameters, start, gain, slow_noise, slow_memory };
  static constexpr int others = 5;
  static constexpr int max_globals = sim::Parameters::max_parameters + others;

  /// The number of slow-noise globals, at the end: its ratio to the white noise, and its memory. Warm-up estimates
  /// both, and they stay fixed while chains draw, because chains mix far more slowly in them. The estimate is plugged
  /// in: intervals do not contain its uncertainty, except that chains have different estimates.
  static constexpr int held = 2;

  /// Throws Error if the protocol is invalid, has fewer than 20 blocks of samples, noise of a single frequency,
  /// above max_noise_hz or below its first harmonic, or a body model that require_family() refuses, and for priors out
  /// of their bounds.
  Density(const sim::Protocol& protocol, const Priors& priors, Isa isa = chosen_isa());

  const sim::Protocol& protocol() const noexcept { return protocol_; }
  /// Returns the allowed ranges of parameters: the priors', else those of the protocol's body.
  const sim::ParameterTable& ranges() const noexcept { return ranges_; }
  const Priors& priors() const noexcept { return priors_; }
  /// Returns the prior of a parameter, as a function of its coordinate.
  const Quantile& quantile(std::size_t parameter) const { return quantiles_.at(parameter); }
  int parameters() const noexcept { return static_cast<int>(ranges_.size()); }
  int globals() const noexcept { return parameters() + others; }
  /// Returns the place of a quantity among the globals, and the quantity at a place.
  std::size_t place(int quantity) const noexcept {
    return static_cast<std::size_t>(quantity < sensor_noise ? quantity : parameters() + quantity - sensor_noise);
  }
  int quantity(std::size_t place) const noexcept {
    const int global = static_cast<int>(place);
    return global < parameters() ? global : global - parameters() + sensor_noise;
  }
  bool is_held(std::size_t place) const noexcept { return static_cast<int>(place) + held >= globals(); }
  /// Returns the number of coordinates: the noise's plus globals().
  int size() const noexcept { return noise_.size() + globals(); }
  int noise_size() const noexcept { return noise_.size(); }
  int blocks() const noexcept { return blocks_; }
  double noise_period_s() const noexcept { return noise_.period_s(); }
  double noise_hz(int coefficient) const noexcept { return noise_.frequency_hz(coefficient); }
  /// Lengths of the Fourier transforms, and the number of noise transforms per evaluation in each direction.
  struct Transforms {
    int sway, noise, noise_count;
  };
  Transforms transforms() const;
  /// Returns false for quantities with a fixed value: parameters, start and gain may be fixed.
  bool infers(int quantity) const noexcept {
    if (quantity < sensor_noise) return quantiles_[static_cast<std::size_t>(quantity)].range > 0.0;
    return (quantity != start || priors_.start_s > 0.0) && (quantity != gain || priors_.gain > 0.0);
  }
  /// Returns the begin of the trial's first bin, at the protocol's start or just before.
  double first_bin_s() const noexcept { return first_step_ * sim::integration_step_s; }
  double bin_s() const noexcept { return bin_steps_ * sim::integration_step_s; }
  double block_s() const { return block_samples_ / protocol_.experiment.sample_rate_hz; }
  /// Returns the standard deviation of the vestibular noise's coordinates at these parameters.
  double noise_radius(const sim::Parameters& parameters) const;
  /// Returns the white noise in the mean of a block: measurement noise plus the model's own error.
  double block_noise_rad(double sensor_noise_deg) const;
  /// Returns the number of bin edges within the trial: edge i is at first_bin_s() + i * bin_s().
  int edges() const noexcept { return edges_; }
  Isa isa() const noexcept { return isa_; }

  /// Prepares a recording; sway_rad: the protocol's samples. gaps: ranges of samples that were not measured, which may
  /// have any values; the likelihood ignores the blocks that they touch. Throws Error for another number of samples,
  /// for gaps outside of them or too long (max_missing_s), for other samples that are not finite, and if the recording
  /// is constant.
  Observation observe(std::span<const float> sway_rad, std::span<const SampleRange> gaps = {}) const;
  /// Returns the observation of a body that never moves, for what does not depend on the recorded sway.
  Observation at_rest() const;

  /// Returns the quantities of a chain's coordinates; x: size() values per chain.
  State state(std::span<const double> x, int chain) const;
  /// Sets a chain's coordinates except the noise's. Values outside of their ranges, or within a hundredth of the ends,
  /// move to that hundredth.
  void set(const State& state, std::span<double> x, int chain) const;
  /// Returns the standard normal coordinate of a quantity of a state; for a value outside of its range, the coordinate
  /// of the range's hundredth. The slow noise's coordinate depends on the white noise.
  double prior_coordinate(int quantity, const State& state) const;
  /// Sets a chain's coordinates of the measurement noise levels.
  void set_noise(double sensor_noise_deg, double slow_noise_deg, std::span<double> x, int chain) const;

  class Workspace {
   public:
    explicit Workspace(const Density& density);

   private:
    friend class Density;
    AlignedVector<double> velocity, fine, by_fine, halves, by_halves, passed, by_low, by_high, by_theta, by_passed,
        by_velocity;
    AlignedVector<double> bins_spectrum, sway_spectrum, delayed, inverse, sway, observe, loop_spectrum, modelled,
        residual, unfolded;
    NoiseWorkspace noise;
    AlignedVector<double> fft_work, noise_work, columns, products, noise_column, fine_column, response;
  };

  // The functions below throw Error for spans of other sizes, and for the observation of another density.
  /// Computes minus the logarithm of the density of each chain, up to a constant, and its gradient; x, gradient: size()
  /// values per chain. fixed_noise_deg: fixes the measurement noise during annealing; its coordinate then has a
  /// standard normal prior.
  void evaluate(const Observation& observation, std::span<const double> x, std::span<double> gradient,
                std::span<double> potential, Workspace& work, std::optional<double> fixed_noise_deg = {}) const;
  /// The number of standard normals per chain that draw_white_noise() takes, and of uniform numbers.
  static constexpr std::size_t white_noise_draws = 8;
  /// Moves the white noise's coordinate of each chain by Metropolis steps that keep its distribution given all other
  /// coordinates. Chains travel slowly along it, because it changes the widths of all coefficients of the vestibular
  /// noise; given these it is determined by the residual alone. normals, uniforms: white_noise_draws values per chain.
  void draw_white_noise(const Observation& observation, std::span<double> x, std::span<const double> normals,
                        std::span<const double> uniforms, Workspace& work) const;
  /// Computes the modelled sway of each chain, offset and straight line included: the means of blocks, rad, blocks()
  /// values per chain. residual_rad: the recorded sway minus the modelled one, 0 in missing blocks.
  void model(const Observation& observation, std::span<const double> x, std::span<double> sway_rad,
             std::span<double> residual_rad, Workspace& work) const;
  /// Computes log p of each block's mean, in degrees, given all other blocks and the chain's unknowns; blocks() values
  /// per chain, 0 for missing blocks.
  void leave_block_out(const Observation& observation, std::span<const double> x, std::span<double> log_density,
                       Workspace& work) const;
  /// Computes the perception of each chain's controller: the velocity of its vestibular noise at the dead band, rad/s,
  /// and its estimate of the platform's tilt, rad. The estimate is the integral of the passed velocity since the start.
  /// edges() values per chain each.
  void perceive(std::span<const double> x, std::span<double> noise_rad_s, std::span<double> tilt_rad,
                Workspace& work) const;
  /// Computes the information of each chain about its coordinates, at its point: J^t J / noise^2 (Gauss-Newton) plus
  /// the prior's. A lower triangle, row after row, triangle(size()) values per chain.
  void information(const Observation& observation, std::span<const double> x, std::span<double> matrices,
                   Workspace& work, std::optional<double> fixed_noise_deg = {}) const;

 private:
  struct Chains;       // quantities of each chain's coordinates, chain by chain
  class PlatformRate;  // the platform's velocity, step by step
  class Jacobian;      // of the blocks by all coordinates, divided by their noise
  /// Derivatives of the misfit by the modelled blocks, with the residual's sign.
  struct ModelDerivatives {
    std::array<double, loop_sums * lanes> loop{};  // LoopGradient::sums
    std::array<double, lanes> gain, theta;         // of the dead band
  };

  Density(const sim::Protocol& protocol, const Priors& priors, Isa isa, const sim::Stimulus& stimulus);
  void set_bins(const PlatformRate& rate_at);
  /// Sets the platform's transform, from its steps.
  void set_platform(const PlatformRate& rate_at);
  /// Sets what the loop needs per frequency, except the platform's transform.
  void set_loop();
  void set_unbinned();
  /// Length of the transforms.
  double padded_s() const noexcept { return padded_blocks_ * bin_s(); }
  long long padded_steps() const noexcept { return static_cast<long long>(padded_blocks_) * bin_steps_; }

  Chains chains(std::span<const double> x, std::optional<double> fixed_noise_deg) const;
  LoopParameters loop_parameters(const Chains& chains) const;
  DeadBandBins halves() const;
  DeadBandValues dead_band_values(const Chains& chains, Workspace& work) const;
  LoopConstants constants(const Observation& observation) const;
  const sim::Family& family() const noexcept { return protocol_.family(); }
  /// Returns the derivatives by the family's coefficients from the loop's sums and those by gain and threshold of the
  /// dead band.
  std::array<double, sim::Coefficients::count> by_coefficients(std::span<const double> sums, double by_nv,
                                                               double by_theta, std::size_t chain) const;
  void check(const Observation& observation, std::span<const double> x, std::size_t results,
             std::size_t expected) const;
  /// Computes the residual's cosine transform from the coordinates; returns minus the logarithm of the likelihood.
  std::array<double, lanes> forward(const Observation& observation, std::span<const double> x, const Chains& chains,
                                    Workspace& work) const;
  /// Passes the residual's derivatives back through the loop, the dead band and the noise; call it after forward().
  /// Writes those by the noise's coefficients to gradient, per pass_back().
  ModelDerivatives backward(const Observation& observation, const Chains& chains, std::span<double> gradient,
                            Workspace& work) const;
  /// Adds the model's derivatives to those of the globals of a chain, except the noise levels.
  void add_model_gradient(const Chains& chains, const ModelDerivatives& derivatives, std::size_t chain,
                          std::span<double> gradient) const;
  /// Returns the factor of derivatives that passed back through the dead band: of the inverse transform, and of the
  /// pairs of frequencies.
  double pass_back() const noexcept { return 0.5 * padded_blocks_; }
  /// Converts a transform of the observed sway in work.sway_spectrum to blocks in work.modelled.
  void to_blocks(Workspace& work) const;
  /// Returns the trial's blocks among all modelled ones.
  const double* trial_blocks(const AlignedVector<double>& blocks) const {
    return blocks.data() + static_cast<std::ptrdiff_t>(lead_blocks_) * lanes;
  }
  /// Sets the levels of a chain's measurement noise by the three coordinates.
  void set_noise(Chains& chains, std::size_t chain, double white, double slow, double memory,
                 std::optional<double> fixed_noise_deg) const;
  /// Returns the changes of the logarithm of a coefficient's power, row by row of the cosine transform, with the
  /// coordinates of white noise, slow noise and its memory; call it after forward().
  std::array<double, 3> power_changes(const Chains& chains, const Workspace& work, std::size_t row,
                                      std::size_t chain) const;
  void add_prior_information(const Chains& chains, std::span<double> matrices) const;
  /// Adds the information about the measurement noise levels; call it after forward().
  void add_noise_information(const Chains& chains, const Workspace& work, std::span<double> matrices) const;
  double noise_of_highest(std::span<const double> sway) const;
  Observation prepared(std::span<const float> sway_rad, std::span<const SampleRange> gaps) const;

  sim::Protocol protocol_;
  Priors priors_;
  sim::ParameterTable ranges_;
  Isa isa_;
  std::vector<Quantile> quantiles_;         // of the parameters
  bool unit_gains_;                         // Family::has_unit_gains
  int block_samples_, bin_steps_, blocks_;  // a bin is as long as a block
  int lead_blocks_, lead_steps_;            // before the trial
  int first_step_, bins_, edges_, padded_blocks_, frequencies_;
  double damping_;  // c, 1/s
  NoiseBasis noise_;
  sim::RealFft fft_;
  NoiseSpectrum spectrum_;
  AlignedVector<double> rate_low_, rate_high_, weight_, undamp_;
  AlignedVector<double> s_, sum_, rate_, body_, hold_, observe_, platform_, unbinned_;
  AlignedVector<double> derivative_, slow_response_, torque_response_;  // empty with unit gains
};

}  // namespace decid::posterior
