// Measures how well parameters explain the trial that they were identified from, for any method: simulates trials from
// the parameters and compares them with it.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "identify/estimate.hpp"
#include "identify/response_ratio.hpp"
#include "sim/simulate.hpp"

namespace decid {

/// Parameters, and the trial that they are to explain.
struct Answer {
  const sim::Parameters& parameters;
  const recording::Trial& trial;
  /// Level of the warning that the parameters explain less of the trial than of simulated ones. For a posterior it is
  /// info, because its noise explains the rest and is checked separately.
  Severity little_explained = Severity::caution;
  double start_s = 0.0;  ///< of the trial after the protocol's: simulated trials are compared from there on
  double gain = 1.0;     ///< recorded over true sway: simulated trials are multiplied by it
};

/// The plans for trials of one protocol, made once: immutable, so one serves all threads.
class Explainer {
 public:
  explicit Explainer(const sim::Simulator& simulator);

  const sim::Simulator& simulator() const noexcept { return simulator_; }
  /// The platform at the trials' samples, as the protocol prescribes it.
  std::span<const float> tilt_rad() const noexcept { return tilt_rad_; }

  /// Simulates trials as the recording has them: from its start on, with its gain, and with its gaps bridged.
  /// Computes the noise-free trial, its residual, the stimulus response ratio, and the frequency responses; warns if
  /// the parameters explain less than their noise accounts for. Simulates 33 trials for each answer, and several
  /// answers together, so that the simulator's lanes are full. An explanation does not depend on the others.
  /// `ood_score` needs a model and is set elsewhere.
  std::vector<Explanation> explain(std::span<const Answer> answers) const;
  Explanation explain(const Answer& answer) const { return std::move(explain(std::span(&answer, 1)).front()); }

 private:
  struct Simulated;
  std::vector<Simulated> simulate(std::span<const Answer> answers) const;
  Explanation explain(const Answer& answer, Simulated simulated) const;

  sim::Simulator simulator_;
  std::vector<float> tilt_rad_;
  std::optional<ResponseRatio> response_ratio_;  // empty: a length that no transform is planned for
  std::optional<sim::FrequencyResponse> frf_;
  std::string no_frf_;  // why there is none
};

/// Computes the frequency responses of a trial, its gaps bridged, and of its simulated trial, by `analysis`; tilt_rad:
/// the protocol's. The closed loop's have the answer's start and gain too.
FrequencyResponses frequency_responses(const sim::FrequencyResponse& analysis, const Answer& answer,
                                       std::span<const float> sway_rad, std::span<const float> fitted_rad,
                                       std::span<const float> tilt_rad, const sim::Experiment& experiment);
/// Returns the analysis of a protocol's trials: it omits the first of three or more cycles, with the transient from
/// rest. Throws Error as sim::FrequencyResponse does.
sim::FrequencyResponse frequency_analysis(const sim::Experiment& experiment);

/// Simulates the trial of `parameters` without vestibular noise, up to where the body falls.
std::vector<float> noise_free_trial(const sim::Simulator& simulator, const sim::Parameters& parameters);

/// Returns a warning if an explained recording does not follow the tilt; for recordings that no model has judged. A
/// fit's gain may explain a sensor's scale, but no other tilt and no other unit: the response counts with the gain.
/// start_explains: the recording starts elsewhere, so a weak response is expected.
Warnings response_ratio_warnings(const Explanation& explanation, bool start_explains = false);

/// Returns the warnings without `slow_lean` if another one says that the sway has another scale or sign, or resembles
/// no simulated trial: the cycles of such a sway differ more too, and another trial would not help.
Warnings without_refused_lean(Warnings warnings);

}  // namespace decid
