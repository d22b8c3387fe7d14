// One thread's lanes and the trials that pass through them: a trial that ends, or falls, gives its lane to the next.
// The steps themselves are kernels (kernels/generic_pendulums.hpp). Not installed.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "sim/kernels/kernels.hpp"
#include "sim/simulate.hpp"

namespace decid::sim {

/// A protocol as the kernels need it.
struct Setup {
  Setup(Protocol valid_protocol, Isa isa);

  Protocol protocol;
  Isa isa;
  Stimulus stimulus;
  VestibularNoiseMaker noise_maker;
  int samples;
  std::vector<double> tilt_and_rate;  ///< of each interval of the stimulus
};

/// What a step computes with that does not change from trial to trial.
StepConstants make_step_constants(const Experiment& experiment, const Stimulus& stimulus);
/// step / J m g h times the coefficients of the polynomial for (sin a - a) / a^3, lowest first.
std::array<double, 3> sine_of(const Body& body);

class Lanes {
 public:
  /// The setup must outlive the lanes.
  explicit Lanes(const Setup& setup);

  /// Runs the trials that `next` names, until it returns a negative index and all lanes are free; it is asked again
  /// whenever a lane is free. After an exception the lanes cannot be used again.
  void run(const std::function<int()>& next, const Simulator::TrialOf& trial_of, const Simulator::Finished& finished);

 private:
  /// The noises of fft_lanes trials, side by side, and how many of those are not over.
  struct NoiseBlock {
    std::vector<double> rate;
    int users = 0;
  };
  struct Prepared {
    int index;
    Parameters parameters;
    Body body;
    NoiseBlock* noise;  // null: none
    const double* noise_rate;
  };
  /// The trial in a lane.
  struct Work {
    int index = -1;  // negative: none
    int samples_left = 0;
    int lag = 0;
    NoiseBlock* noise = nullptr;
  };

  double* sway_of(int lane) { return sways_.get() + static_cast<std::size_t>(lane) * samples_; }
  /// Fetches as many trials as have their noise made at once; none when `next` has no more.
  void prepare(const std::function<int()>& next, const Simulator::TrialOf& trial_of);
  NoiseBlock* free_noise();
  /// Leaves a lane without a trial: it stays at zero.
  void rest(int lane);
  void begin(int lane, const Prepared& trial, double* sway);
  void advance(int samples);
  /// Moves the commands that a lane can still ask for to where there is room behind them.
  void move_commands_back();
  void end_if_over(int lane, const Simulator::Finished& finished);

  const Setup& setup_;
  AdvancePendulums advance_;
  std::size_t samples_, intervals_;  // intervals: of the stimulus, a sample
  StepConstants step_constants_{};
  std::unique_ptr<Pendulums> lanes_;
  std::array<Work, Pendulums::count> works_{};
  std::vector<double> silence_;
  std::unique_ptr<double[]> sways_;  // a row for each lane, and one for those at rest
  std::vector<std::unique_ptr<NoiseBlock>> noises_;
  std::vector<Prepared> waiting_;
};

}  // namespace decid::sim
