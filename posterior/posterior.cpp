// Draws from the posterior: see posterior.hpp.
#include "posterior/posterior.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <limits>

#include "base/error.hpp"
#include "base/math/statistics.hpp"
#include "base/parallel.hpp"
#include "base/setting.hpp"
#include "posterior/sampling/detail/chain_group.hpp"
#include "posterior/sampling/diagnostics.hpp"

namespace decid::posterior {
namespace {

constexpr int min_judged_draws = 4;     // draws per chain
constexpr double repeating_rhat = 1.2;  // chains' means vary by 0.44 of the variance within them
// Draws of all chains together contain the chains' differences. Up to this R-hat they err less than the network does
// (docs/research/posterior.md).
constexpr double apart_rhat = 1.5;

void check(const Settings& settings) {
  const auto at_least = [](const std::string& setting, int value, int minimum) {
    require_at_least("posterior, " + setting, value, minimum);
  };
  at_least("groups", settings.groups, 1);
  at_least("annealing_transitions", settings.annealing_transitions, 1);
  at_least("window_transitions", settings.window_transitions, 6);
  at_least("max_leapfrog_steps", settings.max_leapfrog_steps, 1);
  at_least("rounds", settings.rounds, 1);
  at_least("trial_draws", settings.trial_draws, 6);
  at_least("block", settings.block, 1);
  at_least("max_draws", settings.max_draws, 4);
}

bool are_equal(std::span<const double> draws) {
  return draws.size() > 1 && std::ranges::all_of(draws, [&](double draw) { return draw == draws.front(); });
}

/// Posteriors of more parameters are longer ridges, those of controllers with free gains bend more, and those of
/// several trials are narrower: chains need longer transitions to travel along them.
constexpr int many_parameters = 9;

Settings for_target(Settings settings, const Target& target) {
  check(settings);
  bool is_long = target.trials() > 1;
  for (std::size_t t = 0; t < target.trials(); ++t) {
    const Density& density = target.density(t);
    int inferred = 0;
    for (int p = 0; p < density.parameters(); ++p) inferred += density.infers(p) ? 1 : 0;
    is_long = is_long || inferred >= many_parameters || !density.protocol().family().has_unit_gains();
  }
  if (!is_long) return settings;
  const auto times = [](int& setting, int factor) {
    setting = std::min(setting, std::numeric_limits<int>::max() / factor) * factor;
  };
  times(settings.max_leapfrog_steps, 4);
  times(settings.window_transitions, 5);
  settings.window_transitions /= 3;
  return settings;
}

}  // namespace

double Posterior::value(const State& state, int quantity) {
  switch (quantity) {
    case Density::sensor_noise:
      return state.sensor_noise_deg;
    case Density::start:
      return state.start_s;
    case Density::gain:
      return state.gain;
    case Density::slow_noise:
      return state.slow_noise_deg;
    case Density::slow_memory:
      return state.slow_memory_s;
    default:
      return state.parameters[static_cast<std::size_t>(quantity)];
  }
}

std::vector<double> Posterior::draws_for(int quantity) const {
  std::vector<double> draws;
  for (const State& state : states_) draws.push_back(value(state, quantity));
  return draws;
}

std::vector<std::vector<double>> Posterior::chains_for(int quantity) const {
  std::vector<std::vector<double>> chains(static_cast<std::size_t>(chains_));
  const auto each = static_cast<std::size_t>(draws_per_chain());
  for (std::size_t i = 0; i < each * chains.size(); ++i) chains[i / each].push_back(value(states_[i], quantity));
  return chains;
}

double Posterior::tail_effective_draws(int quantity) const {
  if (draws_per_chain() < min_judged_draws) return std::numeric_limits<double>::quiet_NaN();
  return posterior::tail_effective_draws(chains_for(quantity));
}

double Posterior::monte_carlo_error(int quantity) const {
  if (draws_per_chain() < min_judged_draws) return std::numeric_limits<double>::quiet_NaN();
  return stddev(quantity) / std::sqrt(mean_effective_draws(chains_for(quantity)));
}

// A fixed quantity has its value and 0, without rounding.
double Posterior::mean(int quantity) const {
  const std::vector<double> draws = draws_for(quantity);
  return are_equal(draws) ? draws.front() : decid::mean(draws);
}

double Posterior::stddev(int quantity) const {
  const std::vector<double> draws = draws_for(quantity);
  return are_equal(draws) ? 0.0 : decid::stddev(draws);
}

double Posterior::quantile(int quantity, double probability) const {
  return decid::quantile(draws_for(quantity), probability);
}

double Posterior::correlation(int a, int b) const {
  const double found = decid::correlation(draws_for(a), draws_for(b));
  return a == b && found == 0.0 ? 1.0 : found;
}

bool Posterior::agreed() const {
  return chains_agree(rhat_, effective_);
}

double Posterior::max_rhat() const {
  if (rhat_.empty()) return std::numeric_limits<double>::infinity();
  return *std::ranges::max_element(std::span(rhat_).first(parameters()));
}

bool Posterior::chains_disagree() const {
  return !(max_rhat() <= apart_rhat);
}

class Run {
 public:
  Run(Target target, const Settings& settings, const OnProgress& progress)
      : target_(std::move(target)), settings_(for_target(settings, target_)), progress_(progress) {
    for (int group = 0; group < settings.groups; ++group) groups_.emplace_back(target_, settings_, group, stopped_);
  }

  std::vector<Posterior> operator()() {
    const ChainGroup::Report of_warming = [this](const char* stage, double done) {
      report(stage, warming_fraction * done);
    };
    in_parallel([&](int group) { at(group).warm_up(group == 0 ? of_warming : [](const char*, double) {}); });
    for (int round = 1; !stopped_; ++round) {
      const bool last = round == settings_.rounds;
      in_parallel([&](int group) { at(group).begin_round(last); });
      if (draw_round(last) || last) break;
      in_parallel([&](int group) { at(group).learn_from_round(); });
    }
    return std::move(results_);
  }

 private:
  static constexpr double warming_fraction = 0.4;  // fraction of the whole, for Progress

  ChainGroup& at(int group) { return groups_[static_cast<std::size_t>(group)]; }
  template <class Task>
  void in_parallel(const Task& task) {
    parallel_for(settings_.groups, task);
  }

  /// Returns false if the chains are to begin another round after the trial draws; in the last round they continue.
  bool draw_round(bool last) {
    for (int draws = 0; !stopped_ && draws < settings_.max_draws;) {
      const int more = std::min(settings_.block, settings_.max_draws - draws);
      in_parallel([&](int group) { at(group).draw(more); });
      draws = settings_.max_draws;
      for (const ChainGroup& group : groups_) draws = std::min(draws, group.draws());
      if (draws < min_judged_draws) continue;
      judge(draws);
      if (draws >= settings_.min_draws && (enough() || steps() >= max_steps())) break;
      report("drawing", warming_fraction + (1.0 - warming_fraction) * draws / settings_.max_draws);
      if (!last && draws >= settings_.trial_draws && repeats() && steps() < max_steps() / 2) return false;
    }
    return true;
  }

  /// Judges the first `draws` of each chain.
  void judge(int draws) {
    results_.clear();
    for (std::size_t t = 0; t < target_.trials(); ++t) results_.push_back(of_trial(t, draws));
  }

  Posterior of_trial(std::size_t trial, int draws) const {
    Posterior r;
    r.chains_ = settings_.groups * lanes;
    const auto first = [draws](const auto& values) { return std::span(values).first(static_cast<std::size_t>(draws)); };
    ChainDraws energy;
    for (const ChainGroup& group : groups_) {
      for (std::size_t chain = 0; chain < lanes; ++chain) {
        const auto& points = group.points(trial, chain);
        for (std::size_t i = 0; i < points.size(); ++i) {
          const int draw = (static_cast<int>(i) + 1) * group.apart() - 1;
          if (draw < draws) r.points_.push_back({r.draws() + draw, points[i]});
        }
        const auto states = first(group.states(trial, chain));
        r.states_.insert(r.states_.end(), states.begin(), states.end());
        const auto transitions = first(group.transitions(chain));
        r.transitions_.insert(r.transitions_.end(), transitions.begin(), transitions.end());
        std::vector<double>& of_chain = energy.emplace_back();
        for (const Transition& transition : transitions) of_chain.push_back(transition.energy);
      }
      r.divergences_ += group.divergences();
      r.restarts_ += group.restarts();
      r.leapfrog_steps_ += group.leapfrog_steps();
      r.acceptance_ += group.acceptance() / settings_.groups;
    }
    r.energy_fraction_ = energy_fraction(energy);
    const Density& density = target_.density(trial);
    for (std::size_t place = 0; place + Density::held < static_cast<std::size_t>(density.globals()); ++place) {
      const ChainDraws chains = r.chains_for(density.quantity(place));
      r.rhat_.push_back(rhat(chains));
      r.effective_.push_back(posterior::effective_draws(chains));
    }
    return r;
  }

  /// Returns the leapfrog steps of a group.
  long long steps() const { return groups_.front().leapfrog_steps() / lanes; }

  long long max_steps() const { return (target_.joint() ? 2 : 1) * settings_.max_steps; }

  bool enough() const {
    return std::ranges::all_of(results_, [&](const Posterior& result) {
      return std::ranges::all_of(result.rhat(), [&](double value) { return value <= settings_.max_rhat; }) &&
             std::ranges::all_of(result.effective_draws(),
                                 [&](double value) { return value >= settings_.effective_draws; });
    });
  }

  bool repeats() const {
    return std::ranges::any_of(results_, [](const Posterior& of) { return of.max_rhat() > repeating_rhat; });
  }

  /// A repeated round does not reduce the progress.
  void report(const char* stage, double done) {
    if (!progress_) return;
    done_ = std::max(done_, done);
    double worst = 0.0;
    for (const Posterior& result : results_) worst = std::max(worst, *std::ranges::max_element(result.rhat()));
    if (!progress_({stage, done_, worst})) stopped_ = true;
  }

  const Target target_;
  const Settings settings_;
  const OnProgress& progress_;
  std::deque<ChainGroup> groups_;
  std::atomic<bool> stopped_{false};
  double done_ = 0.0;
  std::vector<Posterior> results_;  // of each trial
};

Posterior sample(const Density& density, const Observation& observation, const Settings& settings,
                 const OnProgress& progress) {
  Run run(Target(density, observation), settings, progress);
  std::vector<Posterior> results = run();
  return results.empty() ? Posterior() : std::move(results.front());
}

std::vector<Posterior> sample_joint(const Target& target, const Settings& settings, const OnProgress& progress) {
  Run run(target, settings, progress);
  std::vector<Posterior> results = run();
  results.resize(target.trials());
  return results;
}

}  // namespace decid::posterior
