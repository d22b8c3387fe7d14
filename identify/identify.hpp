// Identification: from samples of sway to the parameters of the controller behind them.
//
//   const decid::Model model = decid::built_in_model();
//   const decid::RecordingResult result = decid::identify(model, sway_rad, 100.0);
//   use(result.estimate.parameters[decid::sim::Kp], result.explanation.variance_accounted_for, result.trust());
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "identify/estimate.hpp"
#include "identify/explanation.hpp"
#include "identify/network/for_body.hpp"
#include "identify/network/model.hpp"
#include "identify/result.hpp"
#include "nn/predictor.hpp"

namespace decid {

/// Options: where in the samples the protocol starts, and what is subtracted from the samples.
using IdentifyOptions = recording::TrialOptions;

/// Identifies a recording of the model's protocol and explains it. sway_rad: sway of the body's centre of mass, rad, 0
/// upright, positive in the platform's direction of tilt, at rate_hz; it is resampled and cut to the protocol's rate
/// and length (recording::bring_to_protocol). body: the person's or robot's; empty: the model's own (for_body.hpp).
/// Throws Error for samples that are too short, not finite, or constant, and for a body height outside the model's
/// range. Many threads may call it at once.
RecordingResult identify(const Model& model, std::span<const double> sway_rad, double rate_hz,
                         const IdentifyOptions& options = {}, const std::optional<sim::Body>& body = {});

/// Identifies many recordings: sets up once what the function above sets up at every call. One thread may use it at a
/// time; make a copy for each thread, which shares the network's weights and the simulator. The model must outlive it.
class Identifier {
 public:
  /// The maximum number of recordings that go through the network together.
  static constexpr std::size_t max_at_once = 64;

  /// Identifies recordings of the model's own body.
  explicit Identifier(const Model& model) : Identifier(model, for_body(model, "the model", {})) {}
  /// Identifies recordings of that body. expected_at_once: the usual number of recordings in a call of estimate(); the
  /// constructor allocates memory for them.
  Identifier(const Model& model, ForBody body, std::size_t expected_at_once = max_at_once);
  explicit Identifier(Model&& model) = delete;
  Identifier(Model&& model, ForBody body, std::size_t expected_at_once = max_at_once) = delete;
  Identifier(const Identifier& other);
  Identifier& operator=(const Identifier&) = delete;

  const Model& model() const noexcept { return model_; }
  const ForBody& body() const noexcept { return body_; }
  const Explainer& explainer() const noexcept { return *explainer_; }

  /// Identifies and explains the recordings that have no error: sets their estimates, explanations and warnings.
  void identify(std::span<RecordingResult> read);

  /// Returns the network's estimates, in the order of the trials. A trial's estimate does not depend on the others.
  /// Throws Error for a trial of another length than the protocol's, and for one with a value that is not finite.
  std::vector<Estimate> estimate(const std::vector<recording::Trial>& trials) { return run(pointers(trials)); }
  /// Returns how well estimates explain their trials, and the OOD scores of the trials. Simulates trials from the
  /// parameters and compares them with the recorded trials.
  std::vector<Explanation> explain(std::span<const Estimate> estimates,
                                   const std::vector<recording::Trial>& trials) const {
    return compare(estimates, pointers(trials));
  }

 private:
  using Trials = std::vector<const recording::Trial*>;
  static Trials pointers(const std::vector<recording::Trial>& trials);
  std::vector<Estimate> run(const Trials& trials);
  std::vector<Explanation> compare(std::span<const Estimate> estimates, const Trials& trials) const;

  const Model& model_;
  ForBody body_;
  std::shared_ptr<const Explainer> explainer_;
  int at_once_;
  nn::Predictor predictor_;
};

}  // namespace decid
