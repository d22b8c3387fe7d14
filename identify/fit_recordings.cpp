// Posteriors of recordings: see fit_recordings.hpp.
#include "identify/fit_recordings.hpp"

#include <atomic>
#include <chrono>
#include <limits>
#include <mutex>
#include <utility>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "identify/fit_warnings.hpp"

namespace decid {
namespace {

using posterior::Density;
using posterior::Posterior;

/// In trials that explain and check a recording the body stands as in the density.
sim::Protocol standing(sim::Protocol protocol, double standing_s) {
  if (protocol.standing_s == 0.0) protocol.standing_s = standing_s;
  return protocol;
}

sim::Protocol with_body(sim::Protocol protocol, const std::optional<sim::Body>& body) {
  if (body) protocol.experiment.body = *body;
  return protocol;
}

/// Uses the measured tilt, else the request; warns if the tilt contradicts the request.
bool moved_before(const recording::TiltMatch& tilt, bool asked, Warnings& warnings) {
  const bool moved = tilt.moved_before.value_or(asked);
  if (asked && !moved)
    add_caution(warnings, "moved_before",
                "the platform is said to have moved before the protocol's start, but its tilt rested: the tilt counts");
  return moved;
}

}  // namespace

class Fitter::Plan {
 public:
  Plan(const Model* model, const sim::Protocol& protocol, const FitRequest& request)
      : explainer{sim::Simulator(standing(protocol, request.priors.standing_s))},
        density(protocol, request.priors),
        checker(explainer.simulator(), density.block_s()) {
    if (model != nullptr && knows_experiment(*model, protocol.experiment))
      network_.emplace(*model, for_body(*model, "the model", protocol.experiment.body));
  }

  bool has_network() const noexcept { return network_.has_value(); }
  /// From any thread.
  std::pair<Estimate, Explanation> ask_network(const recording::Trial& trial) {
    const std::lock_guard lock(one_at_a_time_);
    std::vector<Estimate> estimates = network_->estimate({trial});
    std::vector<Explanation> explanations = network_->explain(estimates, {trial});
    return {std::move(estimates.front()), std::move(explanations.front())};
  }

  /// For recordings whose tilt shows where the protocol starts, and whether the platform moved before.
  const Density& with_known_start(posterior::Priors priors, bool moved_before) {
    const std::lock_guard lock(one_at_a_time_);
    std::optional<Density>& known = moved_before ? moved_before_ : known_start_;
    if (!known) {
      priors.start_s = 0.0;
      priors.moved_before = moved_before;
      known.emplace(density.protocol(), priors);
    }
    return *known;
  }

  Explainer explainer;
  Density density;
  PredictiveChecker checker;

 private:
  std::mutex one_at_a_time_;  // of what follows
  std::optional<Density> known_start_, moved_before_;
  std::optional<Identifier> network_;
};

Fitter::Fitter(const Model* model, sim::Protocol protocol, const std::optional<sim::Body>& body, FitRequest request)
    : plan_(std::make_unique<Plan>(model, with_body(protocol, body), request)) {
  const std::span<const float> tilt_rad = plan_->explainer.tilt_rad();
  report_.protocol = with_body(std::move(protocol), body);
  report_.body_assumed = !body;
  report_.tilt_rad.assign(tilt_rad.begin(), tilt_rad.end());
  report_.fit = std::move(request);
  report_.network_answers = plan_->has_network();
}
Fitter::~Fitter() = default;

void Fitter::fit(RecordingResult& result, const posterior::OnProgress& progress) {
  const auto begin = std::chrono::steady_clock::now();
  const posterior::Priors& priors = report_.fit->priors;
  const posterior::Settings& settings = report_.fit->settings;
  const recording::Trial& trial = result.trial;
  const Density& density =
      trial.tilt ? plan_->with_known_start(priors, moved_before(*trial.tilt, priors.moved_before, result.warnings))
                 : plan_->density;
  const posterior::Observation observation = density.observe(trial.sway_rad());
  FitFigures& figures = result.fit.emplace();
  figures.posterior = posterior::sample(density, observation, settings, {}, progress);
  const Posterior& found = figures.posterior;
  if (found.draws() == 0) {
    result.error = Error(result.file, "was stopped before anything was drawn", "let it run");
    return;
  }
  const sim::ParameterTable& table = density.protocol().parameters();
  result.estimate.parameters = sim::Parameters(table.size());
  for (std::size_t p = 0; p < table.size(); ++p) result.estimate.parameters[p] = found.mean(static_cast<int>(p));
  double network_unfamiliarity = std::numeric_limits<double>::quiet_NaN();
  std::string unlike_training;
  Warnings contradictions;
  if (plan_->has_network()) {
    auto [answer, explanation] = plan_->ask_network(trial);
    network_unfamiliarity = explanation.ood_score;
    unlike_training = std::move(explanation.unlike_training);
    figures.network = answer.parameters;
    const bool same_priors = priors.parameters.empty();  // as the network was trained with
    if (same_priors && found.apart()) {
      figures.answer = FitFigures::Answer::network;
      result.estimate.parameters = answer.parameters;
      result.estimate.distribution = std::move(answer.distribution);
    } else if (same_priors && answer.distribution) {
      contradictions = contradiction_warnings(table, found, *answer.distribution);
    }
  }
  const bool from_network = figures.answer == FitFigures::Answer::network;
  // The inferred noise explains the rest of the sway, and the predictive check tests whether such noise is usual. So a
  // noise-free trial that explains little is not a fault of the recording.
  result.explanation =
      plan_->explainer.explain({result.estimate.parameters, trial, from_network ? Severity::caution : Severity::info});
  result.explanation.ood_score = network_unfamiliarity;
  figures.check = plan_->checker.check(found.states(), trial, settings.seed);
  Warnings unlike_simulated, unfamiliar;
  const std::string odd = figures.check.warning();
  if (!odd.empty()) add_caution(unlike_simulated, "unlike_simulated", odd);
  // A recording unlike the network's training is not usable if the draws are odd too. The network on its own flags four
  // of a hundred clean trials.
  if (!unlike_training.empty())
    unfamiliar.push_back({!odd.empty() || found.apart() ? Severity::invalid : Severity::caution, "out_of_distribution",
                          "by the network, " + unlike_training});
  result.warnings = gravest_first({result.warnings, unlike_simulated, result.explanation.warnings, unfamiliar,
                                   following_warnings(result.explanation),
                                   posterior_warnings(density, observation, found, from_network), contradictions});
  figures.inferred = posterior::infer(density, observation, found, report_.fit->keeps_log_likelihood);
  for (int i = 0; i < found.points(); ++i) figures.stored_draws.push_back(found.draw_of_point(i));
  figures.posterior.drop_points();
  figures.samples_noise_deg = observation.noise_deg;
  figures.block_s = density.block_s();
  figures.edge_s = density.bin_s();
  figures.first_edge_s = density.first_bin_s();
  figures.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

bool Fitter::fit(std::span<RecordingResult> read, const FitProgress& progress, const OnFitted& fitted) {
  return fit_each(
      read, [this](std::size_t) -> Fitter& { return *this; }, progress, fitted);
}

bool fit_each(std::span<RecordingResult> read, const std::function<Fitter&(std::size_t recording)>& fitter_of,
              const FitProgress& progress, const OnFitted& fitted) {
  std::mutex reporting;
  std::atomic<bool> stopped{false};
  std::atomic<std::size_t> begun{0};
  parallel_for(static_cast<int>(read.size()), [&](int) {
    if (stopped) return;
    const std::size_t number = begun++;  // in their order
    RecordingResult& result = read[number];
    bool cut = false;
    try {
      if (!result.error)
        fitter_of(number).fit(result, [&](const posterior::Progress& here) {
          const std::lock_guard lock(reporting);
          if (progress && !stopped && !progress(number, here)) stopped = true;
          cut = stopped;
          return !cut;
        });
    } catch (const Error& error) {
      result.error = Error(result.file + ", " + error.where(), error.problem(), error.remedy());
    }
    if (result.error) result.fit.reset();
    if (result.fit) result.fit->stopped = cut;
    const std::lock_guard lock(reporting);
    if (fitted) fitted(number);
  });
  return !stopped;
}

Report fit_recordings(const Model* model, const sim::Protocol& protocol, const std::vector<RecordingSource>& sources,
                      const ReadOptions& options, const FitRequest& request) {
  std::vector<RecordingResult> read = read_recordings(protocol, sources, options);
  Fitter fitter(model, protocol, options.body, request);
  fitter.fit(read);
  Report report = fitter.report();
  report.recordings = std::move(read);
  return report;
}

}  // namespace decid
