// Chains that warm up and draw together: see chain_group.hpp.
#include "posterior/sampling/detail/chain_group.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "posterior/streams.hpp"

namespace decid::posterior {
namespace {

constexpr double min_noise_deg = 3.2e-3;  // in the mean of a block twice the model's own error

// Chosen on trials of a seed that is used for no published figure.
constexpr double lowering = 1.6, highest_noise_deg = 3.0;
constexpr int annealing_leapfrog_steps = 15, stages_per_metric = 2;
constexpr double annealing_fraction = 0.6;  // of the time before the first draws, for Progress
constexpr int windows = 3, window_informations = 3, first_window_leapfrog_steps = 48, max_window_leapfrog_steps = 96;
constexpr int settling_transitions = 12, min_leapfrog_steps = 16;
// Over the steps that cross the standard deviation of the widest direction once.
constexpr double leapfrog_steps_per_width = 2.2;
constexpr double target_acceptance = 0.8;
constexpr double stuck_nats = 25.0;  // of one trial; grows with the root of the number of dimensions
constexpr double stranded_log_noise = 0.1;
constexpr double first_slow_noise = 0.02;  // over the white noise of a block

// Streams of random numbers in addition to the samplers'.
constexpr std::uint64_t starting = std::uint64_t{1} << 32, restarting = std::uint64_t{2} << 32;
constexpr std::uint64_t max_windows = 64;  // of a group
constexpr std::uint64_t noise_begin = 1024, noise_of_trial = std::uint64_t{1} << 20;

/// Adds the mean over the chains, by a tree of fixed shape.
void add_mean(std::span<const double> matrices, std::span<double> mean) {
  for (std::size_t i = 0; i < mean.size(); ++i) {
    const double* p = matrices.data() + i * lanes;
    mean[i] += (((p[0] + p[1]) + (p[2] + p[3])) + ((p[4] + p[5]) + (p[6] + p[7]))) / lanes;
  }
}

}  // namespace

ChainGroup::ChainGroup(const Target& target, const Settings& settings, int number, const std::atomic<bool>& stopped)
    : settings_(settings),
      number_(static_cast<std::uint64_t>(number)),
      stopped_(stopped),
      sampler_(target, settings.seed, number_) {
  for (std::size_t t = 0; t < target.trials(); ++t)
    trials_.push_back({.fit = ReparameterisationFit(target.density(t), target.joint())});
}

double ChainGroup::noise_deg(std::size_t trial) const {
  return std::max(target().observation(trial).noise_deg, min_noise_deg);
}

ChainGroup::Place ChainGroup::here() const {
  Place x;
  for (std::size_t t = 0; t < trials_.size(); ++t)
    x.emplace_back(sampler_.coordinates(t).begin(), sampler_.coordinates(t).end());
  return x;
}

/// Sets the chains to draws from the middle of the ranges, which all trials share.
void ChainGroup::place() {
  const Random random(settings_.seed, streams::chains, starting + number_);
  for (std::size_t t = 0; t < trials_.size(); ++t) {
    const std::span<double> x = sampler_.coordinates(t);
    const sim::ParameterTable& table = density(t).ranges();
    for (std::size_t l = 0; l < lanes; ++l) {
      State state;
      std::vector<double> unit;
      for (std::size_t i = 0; i < table.size(); ++i) unit.push_back(random.uniform(l * 64 + i, 0.2, 0.8));
      state.parameters = table.from_unit(unit);
      state.sensor_noise_deg = noise_deg(t);
      density(t).set(state, x, static_cast<int>(l));
    }
    std::vector<double> noise(static_cast<std::size_t>(density(t).noise_size()) * lanes);
    random.fill_normal(noise, noise_begin + t * noise_of_trial);
    std::transform(noise.begin(), noise.end(), x.begin(), [](double normal) { return 0.01 * normal; });
  }
}

/// Returns the root mean square of a trial's blocks that each chain leaves unexplained.
Sampler::Lanes ChainGroup::unexplained_deg(std::size_t trial) const {
  const Density& d = density(trial);
  const auto size = static_cast<std::size_t>(d.blocks()) * lanes;
  std::vector<double> sway(size), residual(size);
  Density::Workspace work(d);
  d.model(target().observation(trial), sampler_.coordinates(trial), sway, residual, work);
  Sampler::Lanes squares{}, found;
  for (std::size_t i = 0; i < size; ++i) squares[i % lanes] = std::fma(residual[i], residual[i], squares[i % lanes]);
  std::ranges::transform(squares, found.begin(),
                         [&](double sum) { return std::sqrt(sum / d.blocks()) / sim::rad_per_deg; });
  return found;
}

/// Returns the measurement noise at which the annealing begins: three times the unexplained part.
double ChainGroup::first_noise_deg(std::size_t trial) const {
  double squares = 0.0;
  for (const double deg : unexplained_deg(trial)) squares += deg * deg / lanes;
  const double last = noise_deg(trial);
  return std::clamp(3.0 * std::sqrt(squares), 2.0 * last, std::max(highest_noise_deg, 2.0 * last));
}

void ChainGroup::metric_from_here() {
  std::vector<std::vector<double>> means;
  for (std::size_t t = 0; t < trials_.size(); ++t) {
    const std::size_t size = triangle(static_cast<std::size_t>(density(t).size()));
    information_.resize(size * lanes);
    sampler_.information(sampler_.coordinates(t), information_, t);
    std::vector<double> mean(size, 0.0);
    add_mean(information_, mean);
    target().parameters_last(t, mean, 1);
    means.push_back(std::move(mean));
  }
  sampler_.set_metric(means);
}

void ChainGroup::adapt(int moves, int leapfrog_steps) {
  for (int move = 0; move < moves && !stopped_; ++move) {
    sampler_.move(leapfrog_steps);
    sampler_.adapt(target_acceptance);
  }
  sampler_.end_adapting();
}

/// Lowers the measurement noise of all trials in stages, each from its own first to its own last.
void ChainGroup::anneal(const Report& report) {
  // Several trials tell more, so the density changes more with the noise.
  const double factor = trials_.size() == 1
                            ? lowering
                            : decid::exp(decid::log(lowering) / std::sqrt(static_cast<double>(trials_.size())));
  double step = 0.2, stages = 1.0;
  for (std::size_t t = 0; t < trials_.size(); ++t) {
    trials_[t].annealed_deg = first_noise_deg(t);
    stages = std::max(stages, decid::log(trials_[t].annealed_deg / noise_deg(t)) / decid::log(factor) + 1.0);
  }
  for (int stage = 0; !stopped_; ++stage) {
    for (std::size_t t = 0; t < trials_.size(); ++t) sampler_.fix_noise(trials_[t].annealed_deg, t);
    if (stage % stages_per_metric == 0) metric_from_here();
    sampler_.begin_adapting(step);
    adapt(settings_.annealing_transitions, annealing_leapfrog_steps);
    step = std::clamp(sampler_.middle_step(), 0.02, 0.4);
    report("annealing", annealing_fraction * std::min(1.0, (stage + 1) / stages));
    bool last = true;
    for (std::size_t t = 0; t < trials_.size(); ++t) {
      double& noise = trials_[t].annealed_deg;
      last = last && noise <= noise_deg(t);
      noise = std::max(noise_deg(t), noise / factor);
    }
    if (last) break;
  }
  release_noise();
  metric_from_here();
}

void ChainGroup::warm_up(const Report& report) {
  place();
  anneal(report);
  for (int window = 0; window < windows && !stopped_; ++window) {
    learn_in_window(window == 0 ? first_window_leapfrog_steps : std::min(leapfrog_steps_, max_window_leapfrog_steps),
                    window + 1 == windows);
    report("warming up", annealing_fraction + (1.0 - annealing_fraction) * (window + 1) / windows);
  }
}

/// last: of a round; the slow noise is fixed from here.
void ChainGroup::learn_in_window(int leapfrog_steps, bool last) {
  sampler_.begin_adapting(sampler_.middle_step());
  begin_window();
  for (int move = 1; move <= settings_.window_transitions && !stopped_; ++move) {
    sampler_.move(leapfrog_steps);
    sampler_.adapt(target_acceptance);
    learn(move, settings_.window_transitions);
  }
  sampler_.end_adapting();
  if (stopped_) return;
  if (last) hold_slow_noise();
  end_window();
}

/// Sets the slow noise to the median of the means of the window's chains: one of them may be elsewhere.
void ChainGroup::hold_slow_noise() {
  std::size_t end = 0;  // of a trial's own globals among all
  for (std::size_t t = 0; t < trials_.size(); ++t) {
    const std::span<double> x = sampler_.coordinates(t);
    end += target().own_globals(t);
    for (std::size_t back = Density::held; back > 0; --back) {
      Sampler::Lanes means{};
      for (std::size_t i = 0; i < globals_.size(); ++i)
        means[i % lanes] += globals_[i][end - back] * lanes / static_cast<double>(globals_.size());
      std::ranges::sort(means);
      const double median = 0.5 * (means[lanes / 2 - 1] + means[lanes / 2]);
      std::ranges::fill(x.subspan(x.size() - back * lanes, lanes), median);
    }
  }
  sampler_.hold_last(true);
}

void ChainGroup::begin_window() {
  for (Trial& trial : trials_) trial.fit.next_window();
  globals_.clear();
  places_.clear();
}

/// Learns from move 1, 2, ... of a window of `moves`. Chains travel in the first third; then every move is a point of
/// the reparameterisation's fit. The last moves of three parts of the window also compute the information.
void ChainGroup::learn(int move, int moves) {
  if (move > moves) return;
  Place x = here();
  const bool informed = move * window_informations / moves != (move - 1) * window_informations / moves;
  if (3 * move > moves) {
    target().append_globals(x, globals_);
    if (!informed)
      for (std::size_t t = 0; t < trials_.size(); ++t) trials_[t].fit.add(x[t]);
  }
  if (informed) places_.push_back(std::move(x));
}

/// Makes reparameterisations and a metric from the window, and the length of transitions.
void ChainGroup::end_window() {
  const Sampler::Lanes badness = log_mass();
  reparameterise();
  restart(badness, stuck_nats * std::sqrt(static_cast<double>(trials_.size())));
  const double leapfrog_steps = leapfrog_steps_per_width * sampler_.widest(globals_) / sampler_.middle_step();
  leapfrog_steps_ = static_cast<int>(
      std::clamp(leapfrog_steps, static_cast<double>(std::min(min_leapfrog_steps, settings_.max_leapfrog_steps)),
                 static_cast<double>(settings_.max_leapfrog_steps)));
  ++windows_;
}

/// Computes the information at the window's places. Returns minus Laplace's logarithm of the probability near each
/// chain's places: that of a Gaussian with the local density and information. It varies between points by the square
/// root of half the dimensions, 12 nats.
Sampler::Lanes ChainGroup::log_mass() {
  Sampler::Lanes sums{};
  for (Trial& trial : trials_) trial.informations.clear();
  for (const Place& x : places_) {
    std::vector<std::vector<double>> factors;
    Sampler::Lanes potential{};
    for (std::size_t t = 0; t < trials_.size(); ++t) {
      std::vector<double>& information =
          trials_[t].informations.emplace_back(triangle(static_cast<std::size_t>(density(t).size())) * lanes);
      sampler_.information(x[t], information, t);
      target().parameters_last(t, factors.emplace_back(information), lanes);
      trials_[t].fit.add(x[t], factors.back());
      const Sampler::Lanes part = sampler_.potential(x[t], t);
      for (std::size_t l = 0; l < lanes; ++l) potential[l] += part[l];
    }
    const Sampler::Lanes half_log_determinant = target().half_log_determinant(factors);
    for (std::size_t l = 0; l < lanes; ++l) sums[l] -= potential[l] + half_log_determinant[l];
  }
  for (double& sum : sums) sum = -sum / static_cast<double>(places_.size());
  return sums;
}

void ChainGroup::reparameterise() {
  std::vector<Reparameterisation> fits;
  std::vector<std::vector<double>> metrics;
  Reparameterisation::Workspace work;
  for (std::size_t t = 0; t < trials_.size(); ++t) {
    const Reparameterisation& fit = fits.emplace_back(trials_[t].fit.fit());
    std::vector<double> metric(triangle(static_cast<std::size_t>(density(t).size())), 0.0);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      fit.change_information(places_[i][t], trials_[t].informations[i], work, density(t).isa());
      add_mean(trials_[t].informations[i], metric);
    }
    for (double& value : metric) value /= static_cast<double>(places_.size());
    target().parameters_last(t, metric, 1);
    metrics.push_back(std::move(metric));
    trials_[t].informations.clear();
  }
  if (!sampler_.set_metric(metrics)) return;
  for (std::size_t t = 0; t < trials_.size(); ++t) sampler_.set_reparameterisation(std::move(fits[t]), t);
}

/// Moves chains that are worse than the best by more than the limit to the place of another chain.
void ChainGroup::restart(const Sampler::Lanes& badness, double limit) {
  // A chain without a finite value is worse than all others.
  const auto of = [&](std::size_t l) {
    return std::isfinite(badness[l]) ? badness[l] : std::numeric_limits<double>::infinity();
  };
  double highest = std::numeric_limits<double>::infinity();
  for (std::size_t l = 0; l < lanes; ++l) highest = std::min(highest, of(l) + limit);
  if (!std::isfinite(highest)) return;
  std::vector<std::size_t> good;
  for (std::size_t l = 0; l < lanes; ++l)
    if (of(l) <= highest) good.push_back(l);
  const Random random(settings_.seed, streams::chains,
                      restarting + number_ * max_windows + static_cast<std::uint64_t>(windows_));
  for (std::size_t l = 0; l < lanes; ++l) {
    if (of(l) <= highest) continue;
    const std::size_t from = good[static_cast<std::size_t>(random.below(l, good.size()))];
    for (std::size_t t = 0; t < trials_.size(); ++t) {
      const std::span<double> x = sampler_.coordinates(t);
      for (std::size_t i = 0; i < x.size(); i += lanes) x[i + l] = x[i + from];
    }
    ++restarts_;
  }
}

/// Ends the annealing: the measurement noise, fixed so far, becomes the part that each chain leaves unexplained. Chains
/// that explain less than others are elsewhere.
void ChainGroup::release_noise() {
  Sampler::Lanes log_noise{};
  for (std::size_t t = 0; t < trials_.size(); ++t) {
    const double of_sensor = sim::rad_per_deg / density(t).block_noise_rad(1.0);
    const Sampler::Lanes unexplained = unexplained_deg(t);
    for (std::size_t l = 0; l < lanes; ++l) {
      log_noise[l] += decid::log(unexplained[l]);
      density(t).set_noise(std::max(min_noise_deg, of_sensor * unexplained[l]), first_slow_noise * unexplained[l],
                           sampler_.coordinates(t), static_cast<int>(l));
    }
    sampler_.fix_noise({}, t);
  }
  restart(log_noise, stranded_log_noise);
  ++windows_;
}

void ChainGroup::begin_round(bool last) {
  last_round_ = last;
  for (Trial& trial : trials_) {
    trial.states = {};
    trial.points = {};
  }
  transitions_ = {};
  apart_ = 1;
  acceptance_ = 0.0;
  divergences_ = 0;
  sampler_.begin_adapting(sampler_.middle_step());
  adapt(settling_transitions, leapfrog_steps_);
  begin_window();
}

void ChainGroup::learn_from_round() {
  sampler_.hold_last(false);
  if (!places_.empty() && !globals_.empty()) end_window();
  learn_in_window(std::min(leapfrog_steps_, max_window_leapfrog_steps), true);
}

void ChainGroup::draw(int count) {
  for (int i = 0; i < count && !stopped_; ++i) {
    sampler_.move(leapfrog_steps_);
    double accepted = 0.0;
    for (std::size_t l = 0; l < lanes; ++l) {
      for (std::size_t t = 0; t < trials_.size(); ++t)
        trials_[t].states[l].push_back(density(t).state(sampler_.coordinates(t), static_cast<int>(l)));
      transitions_[l].push_back({sampler_.log_density()[l], sampler_.energy()[l], sampler_.acceptance()[l],
                                 sampler_.diverged()[l] ? 1.0 : 0.0});
      accepted += sampler_.acceptance()[l] / lanes;
      divergences_ += sampler_.diverged()[l] ? 1 : 0;
    }
    acceptance_ += (accepted - acceptance_) / draws();
    if (draws() % apart_ == 0) keep();
    if (!last_round_) learn(draws(), settings_.trial_draws);
  }
}

/// Keeps the chains' current points. If a chain has too many, every second one is dropped.
void ChainGroup::keep() {
  for (std::size_t t = 0; t < trials_.size(); ++t) {
    const std::span<const double> x = sampler_.coordinates(t);
    for (std::size_t l = 0; l < lanes; ++l) {
      std::vector<double>& point = trials_[t].points[l].emplace_back();
      for (std::size_t i = l; i < x.size(); i += lanes) point.push_back(x[i]);
    }
  }
  const int max_points = std::max(1, Posterior::max_points / (settings_.groups * lanes));
  if (static_cast<int>(trials_.front().points.front().size()) <= max_points) return;
  apart_ *= 2;
  for (Trial& trial : trials_) {
    for (auto& points : trial.points) {
      for (std::size_t i = 1; i < points.size(); i += 2) points[i / 2] = std::move(points[i]);
      points.resize(points.size() / 2);
    }
  }
}

}  // namespace decid::posterior
