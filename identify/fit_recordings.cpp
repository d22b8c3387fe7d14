// Posteriors of recordings: see fit_recordings.hpp.
#include "identify/fit_recordings.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "identify/fit_warnings.hpp"

namespace decid {
namespace {

using posterior::Density;
using posterior::Posterior;

/// What the network finds unlike anything it was trained on is not to be used if the draws are odd as well; by itself
/// that is so for four of a hundred sound trials.
void warn_of_unfamiliarity(const Explanation& networks, bool draws_are_odd, Explanation& explanation) {
  explanation.unfamiliarity = networks.unfamiliarity;
  for (const Warning& warning : networks.warnings)
    if (warning.code == "unfamiliar")
      explanation.warnings.push_back(
          {draws_are_odd ? Severity::invalid : Severity::caution, warning.code, "by the network, " + warning.text});
}

/// The noise that was inferred explains what a trial without noise does not, and the predictive check asks whether
/// such noise is usual: how little the trial without noise explains is no fault of the recording.
void explain_by_noise(Explanation& explanation) {
  for (Warning& warning : explanation.warnings)
    if (warning.code == "little_explained") warning.severity = Severity::info;
}

/// Trials that explain and check a recording stand as the density has it.
sim::Protocol standing(sim::Protocol protocol, double standing_s) {
  if (protocol.standing_s == 0.0) protocol.standing_s = standing_s;
  return protocol;
}

class Fitter {
 public:
  Fitter(const Model* model, const sim::Protocol& protocol, const FitRequest& request)
      : explainer_{sim::Simulator(standing(protocol, request.priors.standing_s))},
        request_(request),
        density_(protocol, request.priors),
        checker_(explainer_.simulator(), density_.block_s()) {
    if (model != nullptr && knows_experiment(*model, protocol.experiment))
      network_.emplace(*model, for_body(*model, "the model", protocol.experiment.body));
  }

  std::span<const float> tilt_rad() const { return explainer_.tilt_rad(); }

  /// From any thread.
  FitFigures fit(Identification& id, const posterior::OnProgress& progress) {
    FitFigures figures;
    const auto begin = std::chrono::steady_clock::now();
    const recording::Trial& trial = id.estimate.trial;
    const Density& density = trial.tilt ? with_known_start(moved_before(id.estimate)) : density_;
    const posterior::Observation observation = density.observe(trial.sway_rad());
    figures.posterior = posterior::sample(density, observation, request_.settings, {}, progress);
    const Posterior& found = figures.posterior;
    if (found.draws() == 0) {
      id.error = Error(id.file, "was stopped before anything was drawn", "let it run");
      return figures;
    }
    const sim::ParameterTable& table = density.protocol().parameters();
    id.estimate.parameters = sim::Parameters(table.size());
    for (std::size_t p = 0; p < table.size(); ++p) id.estimate.parameters[p] = found.mean(static_cast<int>(p));
    std::optional<Explanation> networks;
    Warnings contradictions;
    if (network_) {
      const std::lock_guard lock(one_at_a_time_);
      Estimate answer = std::move(network_->estimate({trial}).front());
      networks = std::move(network_->explain(std::span(&answer, 1)).front());
      figures.network = answer.parameters;
      const bool same_priors = request_.priors.parameters.empty();  // as the network was trained with
      if (same_priors && found.apart()) {
        figures.answer = FitFigures::Answer::network;
        id.estimate.parameters = answer.parameters;
        id.estimate.distribution = std::move(answer.distribution);
      } else if (same_priors && answer.distribution) {
        warn_of_contradiction(table, found, *answer.distribution, contradictions);
      }
    }
    id.explanation = explainer_.explain({id.estimate.parameters, trial});
    if (figures.answer == FitFigures::Answer::posterior) explain_by_noise(id.explanation);
    figures.check = checker_.check(found.states(), trial, request_.settings.seed);
    const std::string odd = figures.check.warning();
    if (!odd.empty())
      id.explanation.warnings.insert(id.explanation.warnings.begin(), {Severity::caution, "unlike_simulated", odd});
    if (networks) warn_of_unfamiliarity(*networks, !odd.empty() || found.apart(), id.explanation);
    warn_unless_following(id.explanation);
    warn_of_posterior(density, observation, found, figures.answer == FitFigures::Answer::network,
                      id.explanation.warnings);
    id.explanation.warnings.insert(id.explanation.warnings.end(), contradictions.begin(), contradictions.end());
    figures.inferred = posterior::infer(density, observation, found);
    figures.samples_noise_deg = observation.noise_deg;
    figures.block_s = density.block_s();
    figures.edge_s = density.bin_s();
    figures.first_edge_s = density.first_bin_s();
    figures.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return figures;
  }

 private:
  /// By the measured tilt, else as the request has it; warns of a request that the tilt contradicts.
  bool moved_before(Estimate& estimate) const {
    const bool asked = request_.priors.moved_before;
    const bool moved = estimate.trial.tilt->moved_before.value_or(asked);
    if (asked && !moved)
      add_caution(
          estimate.warnings, "moved_before",
          "the platform is said to have moved before the protocol's start, but its tilt rested: the tilt counts");
    return moved;
  }

  /// For recordings whose tilt says where the protocol starts, and whether the platform moved before.
  const Density& with_known_start(bool moved_before) {
    const std::lock_guard lock(one_at_a_time_);
    std::optional<Density>& known = moved_before ? moved_before_ : known_start_;
    if (!known) {
      posterior::Priors priors = request_.priors;
      priors.start_s = 0.0;
      priors.moved_before = moved_before;
      known.emplace(density_.protocol(), priors);
    }
    return *known;
  }

  Explainer explainer_;
  FitRequest request_;
  Density density_;
  PredictiveChecker checker_;
  std::mutex one_at_a_time_;  // of what follows
  std::optional<Density> known_start_, moved_before_;
  std::optional<Identifier> network_;
};

/// What is wrong with a recording is its own error, and does not end the others.
FitFigures fit_or_fail(Fitter& fitter, Identification& id, const posterior::OnProgress& progress) {
  try {
    return fitter.fit(id, progress);
  } catch (const Error& error) {
    id.error = Error(id.file + ", " + error.where(), error.problem(), error.remedy());
    return {};
  }
}

}  // namespace

const char* name(FitFigures::Answer answer) {
  return answer == FitFigures::Answer::network ? "network" : "posterior";
}

FittedRecordings fit_recordings(const Model* model, sim::Protocol protocol, const std::vector<RecordingSource>& sources,
                                const ReadOptions& options, const FitRequest& request, const FitProgress& progress,
                                const OnFitted& fitted) {
  std::vector<Identification> read = read_recordings(protocol, sources, options);
  return fit_recordings(model, std::move(protocol), std::move(read), options.body, request, progress, fitted);
}

FittedRecordings fit_recordings(const Model* model, sim::Protocol protocol, std::vector<Identification> read,
                                const std::optional<sim::Body>& body, const FitRequest& request,
                                const FitProgress& progress, const OnFitted& fitted) {
  if (body) protocol.experiment.body = *body;
  Fitter fitter(model, protocol, request);
  FittedRecordings all;
  all.identified.protocol = protocol;
  all.identified.body_assumed = !body;
  all.identified.tilt_rad.assign(fitter.tilt_rad().begin(), fitter.tilt_rad().end());
  all.identified.recordings = std::move(read);
  all.fits.resize(all.identified.recordings.size());
  // Recordings are begun in their order.
  std::mutex reporting;
  std::atomic<bool> stopped{false};
  std::atomic<std::size_t> begun{0};
  parallel_for(static_cast<int>(all.fits.size()), [&](int) {
    if (stopped) return;
    const std::size_t number = begun++;
    Identification& id = all.identified.recordings[number];
    bool cut = false;
    if (!id.error) {
      all.fits[number] = fit_or_fail(fitter, id, [&](const posterior::Progress& here) {
        const std::lock_guard lock(reporting);
        if (progress && !stopped && !progress(number, here)) stopped = true;
        cut = stopped;
        return !cut;
      });
    }
    all.fits[number].stopped = cut;
    const std::lock_guard lock(reporting);
    if (fitted) fitted(all, number);
  });
  all.identified.recordings.resize(begun);
  all.fits.resize(begun);
  return all;
}

}  // namespace decid
