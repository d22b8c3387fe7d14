// How well parameters explain the trial that they were identified from, by whatever method: trials are simulated from
// them and compared with it.
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
  /// How grave it is if the parameters explain less of the trial than of simulated ones: for a posterior, whose noise
  /// explains the rest and is checked by itself, it is info.
  Severity little_explained = Severity::caution;
};

/// The plans for trials of one protocol, made once: immutable, so one serves all threads.
class Explainer {
 public:
  explicit Explainer(const sim::Simulator& simulator);

  const sim::Simulator& simulator() const noexcept { return simulator_; }
  /// The platform at the trials' samples, as the protocol prescribes it.
  std::span<const float> tilt_rad() const noexcept { return tilt_rad_; }

  /// The noise-free trial, its residual, whether the recording follows the tilt, and the frequency responses; warns if
  /// the parameters explain less than their noise accounts for. 33 trials are simulated for each answer, those of
  /// several together, so that the simulator's lanes are full; an explanation does not depend on the others.
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

/// The frequency responses of a trial and of its answer's, by `analysis`; tilt_rad: the protocol's.
FrequencyResponses frequency_responses(const sim::FrequencyResponse& analysis, const Answer& answer,
                                       std::span<const float> fitted_rad, std::span<const float> tilt_rad,
                                       const sim::Body& body);
/// The analysis of a protocol's trials: of three cycles and more the first is left out, with the transient from rest.
/// Throws Error as sim::FrequencyResponse does.
sim::FrequencyResponse frequency_analysis(const sim::Experiment& experiment);

/// The trial of `parameters` without vestibular noise, up to where the body falls.
std::vector<float> noise_free_trial(const sim::Simulator& simulator, const sim::Parameters& parameters);

/// Returns a warning if an explained recording does not follow the tilt: for recordings that no model has judged.
Warnings following_warnings(const Explanation& explanation);

}  // namespace decid
