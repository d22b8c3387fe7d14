// One thread's lanes and the trials in them: a trial that ends or falls gives its lane to the next.
// kernels/generic_pendulums.hpp computes the steps. Not installed.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "sim/kernels/kernels.hpp"
#include "sim/simulate.hpp"

namespace decid::sim {

/// A protocol in the kernels' form.
struct Setup {
  Setup(Protocol valid_protocol, Isa isa);

  Protocol protocol;
  Isa isa;
  Stimulus stimulus;
  VestibularNoiseMaker noise_maker;
  int samples;
  std::vector<double> tilt_and_rate;  ///< per interval of the stimulus
};

/// Returns the constants of a step that all trials share.
StepConstants make_step_constants(const Experiment& experiment, const Stimulus& stimulus);
/// Returns step / J m g h times the coefficients of the polynomial for (sin a - a) / a^3, lowest first.
std::array<double, 3> sine_coefficients_for(const Body& body);

class Lanes {
 public:
  /// The setup must outlive the lanes.
  explicit Lanes(const Setup& setup);

  /// Runs the trials that `next` names, until it returns a negative index and all lanes are free. Calls it whenever a
  /// lane is free. The lanes must not be used after an exception.
  void run(const std::function<int()>& next, const Simulator::TrialOf& make_trial, const Simulator::Finished& finished);

 private:
  /// The interleaved noises of fft_lanes trials, and the number of these trials that still run.
  struct NoiseBlock {
    std::vector<double> rate;
    int users = 0;
  };
  struct Prepared {
    int index;
    Coefficients coefficients;
    Body body;
    NoiseBlock* noise;  // null: no noise
    const double* noise_rate;
  };
  /// The trial in a lane.
  struct Work {
    int index = -1;  // negative: no trial
    int samples_left = 0;
    int lag = 0;
    NoiseBlock* noise = nullptr;
  };

  double* sway_of(int lane) { return sways_.get() + static_cast<std::size_t>(lane) * samples_; }
  /// Fetches as many trials as one noise transform serves; none when `next` has no more.
  void prepare(const std::function<int()>& next, const Simulator::TrialOf& make_trial);
  NoiseBlock* free_noise();
  /// Empties a lane: it stays at zero.
  void rest(int lane);
  void begin(int lane, const Prepared& trial, double* sway);
  void advance(int samples);
  /// Moves the commands that a lane may still need, to make space after them.
  void move_commands_back();
  void end_if_over(int lane, const Simulator::Finished& finished);

  const Setup& setup_;
  AdvancePendulums advance_;
  std::size_t samples_, intervals_;  // intervals: of the stimulus, per sample
  StepConstants step_constants_{};
  std::unique_ptr<Pendulums> lanes_;
  std::array<Work, Pendulums::count> works_{};
  std::vector<double> silence_;
  std::unique_ptr<double[]> sways_;  // a row per lane, and one for lanes at rest
  std::vector<std::unique_ptr<NoiseBlock>> noises_;
  std::vector<Prepared> waiting_;
};

}  // namespace decid::sim
