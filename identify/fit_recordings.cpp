// Posteriors of recordings: see fit_recordings.hpp.
#include "identify/fit_recordings.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <mutex>
#include <utility>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "identify/compared_controllers.hpp"
#include "identify/detail/fit_warnings.hpp"
#include "identify/detail/fitter.hpp"

namespace decid {
namespace {

using posterior::Density;
using posterior::Posterior;

constexpr double odd_rhat = 1.2;                           // of a recording that is unlike the network's training too
constexpr double start_edge_probability = 0.05;            // of the start's prior, at either end
constexpr double other_start_tolerance_s = 0.7;            // to which the response shows a start
constexpr double delay_step_s = 0.005, max_start_s = 1.0;  // of the start's prior behind a low-pass

/// The simulator of trials that explain and check a recording. As in the density, the body stands before the first
/// sample, and the platform moves there or rests.
struct CheckSimulator {
  sim::Simulator simulator;
  /// The platform should move there and rests, because no cycle can be simulated there: the reason. protocol.hpp says
  /// for which protocols.
  std::string why_rests = {};
};

CheckSimulator simulator_before(sim::Protocol protocol, double standing_s, bool moved_before) {
  if (protocol.standing_s == 0.0) protocol.standing_s = standing_s;
  if (!moved_before) return {sim::Simulator(std::move(protocol))};
  sim::Protocol moved = protocol;
  moved.moved_before = true;
  try {
    return {sim::Simulator(std::move(moved))};
  } catch (const Error& error) {
    return {sim::Simulator(std::move(protocol)), error.problem()};
  }
}

/// Returns the trial as it was before a low-pass, with its gaps widened; the trial itself if that is unknown.
recording::Trial without_low_pass(const recording::Trial& trial, double rate_hz) {
  recording::Trial before = trial;
  if (!trial.low_pass || !can_undo(*trial.low_pass)) return before;
  before.sway_rad() = undo(*trial.low_pass, trial.sway_rad(), rate_hz);
  before.gaps = gaps_after_undo(*trial.low_pass, trial.gaps, rate_hz, trial.sway_rad().size());
  return before;
}

/// Returns the warnings of a recording that had a low-pass as those of its trial without_low_pass(): the warning of the
/// sway as recorded is information, and a caution says if a fit cannot undo the low-pass.
Warnings warnings_without_low_pass(const recording::LowPass& filter, Warnings warnings) {
  for (Warning& warning : warnings)
    if (warning.code == "smooth") warning.severity = Severity::info;
  if (!can_undo(filter))
    add_caution(
        warnings, "smooth",
        format("a fit cannot undo the low-pass that smoothed the sway: at %g Hz it keeps %.0f to %.0f%% of it; give "
               "an unfiltered recording",
               recording::low_pass_hz, 100.0 * filter.gain_low, 100.0 * filter.gain_high));
  return warnings;
}

}  // namespace

class Fitter::Plan {
 public:
  /// The plan of one controller.
  class Controller {
   public:
    Controller(const sim::Protocol& protocol, const posterior::Priors& priors)
        : density(protocol, priors), checks_(density, priors.moved_before) {}

    const std::string& name() const { return density.protocol().experiment.body_model->name; }

    /// Trials that explain and check a recording.
    struct Checks {
      Checks(const Density& density, bool moved_before)
          : Checks(simulator_before(density.protocol(), density.priors().standing_s, moved_before), density.block_s()) {
      }
      Checks(const CheckSimulator& of, double block_s)
          : why_rests(of.why_rests), explainer(of.simulator), checker(of.simulator, block_s) {}

      std::string why_rests;
      Explainer explainer;
      PredictiveChecker checker;
    };
    /// Returns the checks of a recording before which the platform moved, or rested. From any thread.
    const Checks& checks_for(bool moved_before) {
      if (moved_before == density.priors().moved_before) return checks_;
      const std::lock_guard lock(one_at_a_time_);
      if (!other_checks_) other_checks_.emplace(density, moved_before);
      return *other_checks_;
    }

    /// Returns the density for a recording. A measured tilt shows where the protocol starts; a low-pass may have
    /// delayed the sway since then. From any thread.
    const Density& density_for(const recording::Trial& trial, bool moved_before) {
      const double filter_s = trial.low_pass ? trial.low_pass->delay_s() : 0.0;
      if (!trial.tilt && filter_s == 0.0) return density;
      posterior::Priors priors = density.priors();
      if (trial.tilt) priors.start_s = 0.0;
      priors.start_s = std::min(priors.start_s + delay_step_s * std::ceil(filter_s / delay_step_s), max_start_s);
      priors.moved_before = moved_before;
      const std::lock_guard lock(one_at_a_time_);
      return others_.try_emplace({priors.start_s, moved_before}, density.protocol(), priors).first->second;
    }

    const Density density;

   private:
    Checks checks_;
    std::mutex one_at_a_time_;                           // of what follows
    std::map<std::pair<double, bool>, Density> others_;  // by the prior of the start, and moved_before
    std::optional<Checks> other_checks_;
  };

  Plan(const Model* model, const sim::Protocol& protocol, const FitRequest& request)
      : own(protocol, posterior::in_si_units(request.priors, protocol)) {
    if (model != nullptr && knows_experiment(*model, protocol.experiment))
      network_.emplace(*model, for_body(*model, "the model", protocol.experiment.body));
    for (const FitRequest::Other& other : request.others) {
      sim::Protocol of_other = protocol;
      of_other.experiment.body_model = other.controller;
      posterior::Priors priors = request.priors;
      priors.parameters = other.parameters;
      priors = posterior::with_conventions(std::move(priors), of_other.ranges());
      others.emplace_back(of_other, posterior::in_si_units(std::move(priors), of_other));
    }
  }

  bool has_network() const noexcept { return network_.has_value(); }
  /// From any thread.
  std::pair<Estimate, Explanation> ask_network(const recording::Trial& trial) {
    const std::lock_guard lock(one_at_a_time_);
    std::vector<Estimate> estimates = network_->estimate({trial});
    std::vector<Explanation> explanations = network_->explain(estimates, {trial});
    return {std::move(estimates.front()), std::move(explanations.front())};
  }

  Controller own;
  std::deque<Controller> others;

 private:
  std::mutex one_at_a_time_;  // of the network
  std::optional<Identifier> network_;
};

namespace {

/// Throws Error for a parameter that differs between conditions and has a fixed value, which is the same in all.
void refuse_freed_and_fixed(const FitRequest& request) {
  for (const posterior::ParameterPrior& prior : request.priors.parameters)
    if (prior.fixed && std::ranges::find(request.freed, prior.name) != request.freed.end())
      throw Error(Code::setting_conflict, "joint posterior",
                  "parameter '" + prior.name + format("' is fixed at %g in all conditions, and free", *prior.fixed),
                  "do not free it, or let it be inferred");
}

}  // namespace

Fitter::Fitter(const Model* model, sim::Protocol protocol, const std::optional<sim::Body>& body, FitRequest request) {
  if (body) protocol.experiment.body = *body;
  request.priors = posterior::with_conventions(std::move(request.priors), protocol.ranges());
  // The priors alone say it: a recording's tilt may contradict them.
  const bool moved_before = std::exchange(protocol.moved_before, false);
  request.priors.moved_before = request.priors.moved_before || moved_before;
  refuse_freed_and_fixed(request);
  plan_ = std::make_unique<Plan>(model, protocol, request);
  const std::span<const float> tilt_rad = plan_->own.checks_for(request.priors.moved_before).explainer.tilt_rad();
  report_.protocol = std::move(protocol);
  report_.body_assumed = !body;
  report_.tilt_rad.assign(tilt_rad.begin(), tilt_rad.end());
  report_.fit = std::move(request);
  report_.network_answers = plan_->has_network();
}
Fitter::~Fitter() = default;

Fitter::Prepared Fitter::prepare(RecordingResult& result) {
  recording::Trial trial = without_low_pass(result.trial, report_.protocol.experiment.sample_rate_hz);
  if (trial.low_pass) result.warnings = warnings_without_low_pass(*trial.low_pass, std::move(result.warnings));
  const bool asked = report_.fit->priors.moved_before;
  const bool moved = trial.tilt ? trial.tilt->moved_before.value_or(asked) : asked;
  if (asked && !moved)
    add_caution(
        result.warnings, "moved_before",
        setting("moved_before") + " contradicts the measured tilt, which rested before the start; decid uses the tilt");
  if (const std::string& why = plan_->own.checks_for(moved).why_rests; !why.empty())
    add_caution(result.warnings, "moved_before",
                "the platform moved before the start, but rests there in the trials that explain and check this fit, "
                "because no cycle can be simulated before this protocol: " +
                    why);
  const Density& density = plan_->own.density_for(trial, moved);
  posterior::Observation observation = density.observe(trial.sway_rad(), trial.gaps);
  return {std::move(trial), moved, &density, std::move(observation)};
}

void Fitter::fit(RecordingResult& result, const Prepared& prepared, const posterior::OnProgress& progress) {
  const auto begin = std::chrono::steady_clock::now();
  const posterior::Settings& settings = report_.fit->settings;
  bool cut = false;
  conclude(result, prepared,
           posterior::sample(*prepared.density, prepared.observation, settings,
                             noting_stop(part_progress(progress, 0), cut)));
  if (result.error) return;
  result.fit->stopped = is_incomplete(result.fit->posterior, cut, settings);
  fit_others(result, prepared, progress);
  result.fit->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

namespace {

/// Keeps what results show of the draws, and drops their points.
void keep_figures(FitFigures& figures, const Density& density, const posterior::Observation& observation,
                  bool keeps_log_likelihood) {
  figures.inferred = posterior::infer(density, observation, figures.posterior, keeps_log_likelihood);
  for (int i = 0; i < figures.posterior.points(); ++i)
    figures.stored_draws.push_back(figures.posterior.draw_of_point(i));
  figures.posterior.drop_points();
  figures.samples_noise_deg = observation.noise_deg;
  figures.block_s = density.block_s();
  figures.edge_s = density.bin_s();
  figures.first_edge_s = density.first_bin_s();
}

}  // namespace

/// The network's answer to a recording that has draws.
struct Fitter::NetworkAnswer {
  double ood_score = std::numeric_limits<double>::quiet_NaN();
  std::string unlike_training = {};
  Warnings contradictions = {};  ///< of the draws and the network's distribution
  NetworkUse use = NetworkUse::none;
};

Fitter::NetworkAnswer Fitter::ask_network(RecordingResult& result) {
  if (!plan_->has_network()) return {};
  auto [answer, explanation] = plan_->ask_network(result.trial);
  FitFigures& figures = *result.fit;
  figures.network = answer.parameters;
  const bool same_priors = report_.fit->priors.parameters.empty();  // as the network was trained with
  NetworkAnswer network{explanation.ood_score,
                        std::move(explanation.unlike_training),
                        {},
                        same_priors ? NetworkUse::beside : NetworkUse::none};
  if (same_priors && figures.posterior.chains_disagree()) {
    network.use = NetworkUse::answers;
    figures.answer = FitFigures::Answer::network;
    result.estimate.parameters = answer.parameters;
    result.estimate.distribution = std::move(answer.distribution);
  } else if (same_priors && answer.distribution) {
    network.contradictions =
        contradiction_warnings(report_.protocol.parameters(), figures.posterior, *answer.distribution);
  }
  return network;
}

void Fitter::conclude(RecordingResult& result, const Prepared& prepared, Posterior drawn) {
  const recording::Trial& trial = prepared.trial;
  const Density& density = *prepared.density;
  FitFigures& figures = result.fit.emplace();
  figures.posterior = std::move(drawn);
  const Posterior& found = figures.posterior;
  if (found.draws() == 0) {
    result.error = Error(Code::stopped, result.file, "was stopped before anything was drawn", "let it run");
    return;
  }
  result.estimate.parameters = sim::Parameters(density.protocol().parameters().size());
  for (std::size_t p = 0; p < result.estimate.parameters.size(); ++p)
    result.estimate.parameters[p] = found.mean(static_cast<int>(p));
  const NetworkAnswer network = ask_network(result);
  const bool from_network = network.use == NetworkUse::answers;
  // A start well within its prior, and about where the sway's response shows it, explains such a recording.
  const bool start_explains =
      trial.other_start_s && !from_network && density.infers(Density::start) &&
      std::abs(*trial.other_start_s - found.mean(Density::start)) <= other_start_tolerance_s &&
      std::ranges::count(at_edge(density, found, start_edge_probability), int{Density::start}) == 0;
  if (start_explains)
    std::erase_if(result.warnings, [](const Warning& warning) { return warning.code == "other_start"; });
  // The inferred noise explains the rest of the sway, and the predictive check tests whether such noise is usual. So a
  // noise-free trial that explains little is not a fault of the recording.
  const Plan::Controller::Checks& checks = plan_->own.checks_for(prepared.moved);
  result.explanation = checks.explainer.explain(
      {result.estimate.parameters, trial, from_network ? Severity::caution : Severity::info,
       from_network ? 0.0 : found.mean(Density::start), from_network ? 1.0 : found.mean(Density::gain)});
  result.explanation.ood_score = network.ood_score;
  figures.check = checks.checker.check(found.states(), trial, report_.fit->settings.seed);
  Warnings unlike_simulated, out_of_distribution;
  const std::string odd = figures.check.warning();
  if (!odd.empty()) add_caution(unlike_simulated, "unlike_simulated", odd);
  // A recording unlike the network's training is not usable if the draws are odd too: the network on its own also flags
  // some clean trials (docs/reference/accuracy.md).
  if (!network.unlike_training.empty())
    out_of_distribution.push_back({!odd.empty() || found.max_rhat() > odd_rhat ? Severity::invalid : Severity::caution,
                                   "out_of_distribution", "by the network, " + network.unlike_training});
  const Warnings all = most_severe_first(
      {result.warnings, unlike_simulated, result.explanation.warnings, out_of_distribution,
       response_ratio_warnings(result.explanation, start_explains), tilt_warnings(density, found, trial),
       posterior_warnings(density, prepared.observation, found, network.use), falling_warnings(figures.check),
       network.contradictions});
  result.warnings = without_refused_lean(most_severe_first({refuse_unexplained(all)}));
  keep_figures(figures, density, prepared.observation, report_.fit->keeps_log_likelihood);
}

posterior::OnProgress Fitter::part_progress(const posterior::OnProgress& progress, std::size_t fitted) const {
  if (!progress) return {};
  return [&progress, fitted, fits = static_cast<double>(1 + plan_->others.size())](const posterior::Progress& here) {
    return progress({here.stage, (static_cast<double>(fitted) + here.done) / fits, here.rhat});
  };
}

void Fitter::fit_others(RecordingResult& result, const Prepared& prepared, const posterior::OnProgress& progress) {
  const posterior::Settings& settings = report_.fit->settings;
  FitFigures& figures = *result.fit;
  std::vector<ControllerFit> fits;
  std::vector<posterior::LeaveOneOut> left_out{figures.inferred.left_out};
  for (Plan::Controller& other : plan_->others) {
    const recording::Trial& trial = prepared.trial;
    const Density& density = other.density_for(trial, prepared.moved);
    const posterior::Observation observation = density.observe(trial.sway_rad(), trial.gaps);
    ControllerFit& fit = fits.emplace_back();
    fit.controller = other.name();
    bool cut = false;
    fit.posterior =
        posterior::sample(density, observation, settings, noting_stop(part_progress(progress, fits.size()), cut));
    if (is_incomplete(fit.posterior, cut, settings)) {  // fits of different lengths are not compared
      figures.stopped = true;
      return;
    }
    posterior::Inferred inferred = posterior::infer(density, observation, fit.posterior);
    fit.posterior.drop_points();
    fit.check = other.checks_for(prepared.moved).checker.check(fit.posterior.states(), trial, settings.seed);
    fit.warnings = posterior_warnings(density, observation, fit.posterior, NetworkUse::none);
    append(fit.warnings, falling_warnings(fit.check));
    if (const std::string unlike = fit.check.warning(); !unlike.empty())
      add_caution(fit.warnings, "unlike_simulated", unlike);
    fit.sway_rad = std::move(inferred.sway_rad);
    left_out.push_back(std::move(inferred.left_out));
  }
  if (fits.empty()) return;
  figures.others = std::move(fits);
  if (const auto better = compare_controllers(left_out, plan_->own.name(), result.warnings, figures))
    result.warnings = most_severe_first({{*better}, result.warnings});
}

}  // namespace decid
