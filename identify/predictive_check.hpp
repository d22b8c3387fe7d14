// Posterior predictive check: compares a recording with sway simulated from a posterior's draws. Each trial has a
// draw's parameters, start, gain and measurement noise, and independent vestibular noise. Method: Gelman, Meng, Stern,
// Statistica Sinica 6, 1996.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "posterior/density/inferred.hpp"
#include "recording/trial.hpp"
#include "sim/frf.hpp"
#include "sim/simulate.hpp"

namespace decid {

/// A test quantity of the recording and its distribution over the simulated trials. The least-squares line of each sway
/// is subtracted first.
struct CheckedFigure {
  std::string name;  ///< "0.05 to 0.2 Hz" and other bands: the rms there; "frequency response": squared distance from
                     ///< the simulated trials' mean over their variance; "level": the rms; "largest sway"; "between
                     ///< cycles": the standard deviation between cycles. The last three take means over blocks, whose
                     ///< noise the draws know at any sample rate
  bool in_degrees = true;  ///< else it has no unit
  double recorded = 0.0;
  double low = 0.0, middle = 0.0, high = 0.0;  ///< quantiles of the simulated trials: 5%, 50% and 95%
  /// Two-sided p: twice the smaller of the fractions of trials as low or as high as the recording, which counts among n
  /// + 1; 1 at most. Of "frequency response" the fraction as high: fitted draws are nearer to their recording than
  /// to other trials.
  double p = 1.0;
};

/// Responses of sway to tilt, band by band (sim/frf.hpp): of the recording and of the simulated trials, measured alike.
struct CheckedResponses {
  std::vector<sim::FrfPoint> recorded;
  posterior::Band gain;       ///< of the simulated trials, 1
  posterior::Band phase_rad;  ///< of the simulated trials, each within pi of the phase of their mean response
};

struct PredictiveCheck {
  static constexpr int trials = 400;
  /// A p below this limit means that the recording does not come from the model. For a recording of the model, each
  /// figure falls below with probability 0.01 if the draws are the true parameters, and less often if the draws are
  /// fitted to the recording.
  static constexpr double odd = 0.01;

  int standing = 0;                    ///< trials in which the body did not fall; only these are compared
  std::vector<CheckedFigure> figures;  ///< empty if they are fewer than 200: no p could be below `odd`
  posterior::Band sway_rad;  ///< of the simulated trials, each about its mean, in blocks; empty if fewer than 200 stand
  CheckedResponses responses;  ///< empty if fewer than 200 stand, and if the stimulus has no response

  /// Returns a text that lists the figures below `odd`; empty if there are none.
  std::string warning() const;
};

/// The plan for trials of one protocol: immutable, so one serves all threads.
class PredictiveChecker {
 public:
  /// block_s: of PredictiveCheck::sway_rad, and of figures.
  PredictiveChecker(const sim::Simulator& simulator, double block_s);

  /// draws: some; trial: of the protocol's samples. The same bits for any number of threads. Throws Error if there are
  /// no draws or another number of samples.
  PredictiveCheck check(std::span<const posterior::State> draws, const recording::Trial& trial,
                        std::uint64_t seed) const;

 private:
  struct Shown;  // what is compared of one sway
  Shown show(std::span<const float> as_recorded, std::span<const float> tilt_rad) const;
  /// A simulated sway as it would be recorded.
  std::vector<float> record(std::span<const double> sway_rad, const posterior::State& draw, const Random& noise) const;
  double between_cycles_deg(std::span<const float> sway_rad) const;
  std::vector<CheckedFigure> compare(const Shown& recorded, std::span<const Shown> simulated) const;

  sim::Simulator simulator_;
  std::vector<float> tilt_rad_;
  sim::RealFft fft_;
  std::vector<double> window_;
  struct Frequencies {
    std::string name;
    std::size_t first, end;  // lines of the transform
  };
  std::vector<Frequencies> bands_;
  std::optional<sim::FrequencyResponse> frf_;  // empty: this stimulus has none
  std::vector<std::size_t> cycles_;            // where they begin, the sample behind the last too
  std::size_t block_samples_;
};

}  // namespace decid
