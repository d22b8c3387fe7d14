// Draws from the posterior: see posterior.hpp.
#include "identify/posterior/posterior.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <deque>

#include "base/error.hpp"
#include "base/math.hpp"
#include "base/parallel.hpp"
#include "identify/posterior/cholesky.hpp"
#include "identify/posterior/diagnostics.hpp"
#include "identify/posterior/draws.hpp"
#include "identify/posterior/sampler.hpp"

namespace decid::posterior {
namespace {

constexpr double agreeing_rhat = 1.2;     // chains' means vary by 0.44 of the variance within them
constexpr double least_noise_deg = 2e-4;  // the model's own error is about this

// Chosen on trials of a seed that no figure is quoted for.
constexpr double lowering = 1.4, highest_noise_deg = 3.0;
constexpr int annealing_leaps = 20;
constexpr int windows = 3, window_leaps = 64, window_information = 3;
constexpr int settling_moves = 10;
constexpr double target_acceptance = 0.8;
constexpr double stuck_log_noise = 0.04;

void check(const Settings& settings) {
  const auto at_least = [](const char* setting, int value, int least) {
    if (value < least)
      throw Error(std::string("posterior, ") + setting, "is " + std::to_string(value),
                  "give " + std::to_string(least) + " or more");
  };
  at_least("groups", settings.groups, 1);
  at_least("annealing_moves", settings.annealing_moves, 1);
  at_least("window_moves", settings.window_moves, window_information);
  at_least("leaps", settings.leaps, 1);
  at_least("block", settings.block, 1);
  at_least("most_draws", settings.most_draws, 4);
}

double root_mean_square(std::span<const double> values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
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
    default:
      return state.parameters[static_cast<std::size_t>(quantity)];
  }
}

std::vector<double> Posterior::draws_of(int quantity) const {
  std::vector<double> draws;
  for (const State& state : states_) draws.push_back(value(state, quantity));
  return draws;
}

double Posterior::mean(int quantity) const {
  return posterior::mean(draws_of(quantity));
}

double Posterior::deviation(int quantity) const {
  return posterior::deviation(draws_of(quantity));
}

double Posterior::quantile(int quantity, double share) const {
  return posterior::quantile(draws_of(quantity), share);
}

double Posterior::correlation(int a, int b) const {
  const double found = posterior::correlation(draws_of(a), draws_of(b));
  return a == b && found == 0.0 ? 1.0 : found;
}

bool Posterior::agreed() const {
  return !rhat_.empty() && std::ranges::all_of(rhat_, [](double value) { return value <= agreeing_rhat; });
}

class Run {
 public:
  Run(const Density& density, const Observation& observation, const Settings& settings, const OnProgress& progress)
      : density_(density), observation_(observation), settings_(settings), progress_(progress) {
    check(settings);
    if (root_mean_square(observation.sway) == 0.0)
      throw Error("posterior", "the recording is constant", "give a recording of sway");
    for (int group = 0; group < settings.groups; ++group)
      groups_.emplace_back(density, observation, settings.seed, group);
  }

  Posterior operator()(std::span<const State> starts) {
    parallel_for(settings_.groups,
                 [&](int group) { warm_up(groups_[static_cast<std::size_t>(group)], group, starts); });
    int draws = 0;
    while (!stopped_ && draws < settings_.most_draws) {
      const int more = std::min(settings_.block, settings_.most_draws - draws);
      parallel_for(settings_.groups, [&](int group) { draw(groups_[static_cast<std::size_t>(group)], more); });
      draws = static_cast<int>(groups_.front().states.front().size());
      for (const Group& group : groups_) draws = std::min(draws, static_cast<int>(group.states.front().size()));
      if (draws < 4) break;
      judge(draws);
      if (draws >= settings_.least_draws && enough()) break;
      report("drawing", warming_share + (1.0 - warming_share) * draws / settings_.most_draws);
    }
    return result_;
  }

 private:
  static constexpr double warming_share = 0.3;  // of the whole, for Progress

  struct Group {
    Group(const Density& density, const Observation& observation, std::uint64_t seed, int number)
        : sampler(density, observation, seed, static_cast<std::uint64_t>(number)) {}
    Sampler sampler;
    std::array<std::vector<State>, lanes> states;
    std::array<std::vector<double>, lanes> energy;
    double acceptance = 0.0;
    int divergences = 0, restarts = 0;
  };

  void place(Group& group, int number, std::span<const State> starts) {
    const sim::ParameterTable& table = density_.protocol().parameters();
    const Random random(settings_.seed, Stream::posterior, starting + static_cast<std::uint64_t>(number));
    const std::span<double> x = group.sampler.coordinates();
    for (int chain = 0; chain < lanes; ++chain) {
      State state;
      if (!starts.empty()) {
        state = starts[static_cast<std::size_t>(number * lanes + chain) % starts.size()];
      } else {
        std::vector<double> unit;
        for (std::size_t i = 0; i < table.size(); ++i)
          unit.push_back(random.uniform(static_cast<std::uint64_t>(chain) * 64 + i, 0.2, 0.8));
        state.parameters = table.from_unit(unit);
      }
      state.sensor_noise_deg = noise_deg();
      density_.set(state, x, chain);
    }
    std::vector<double> noise(static_cast<std::size_t>(density_.noise_size()) * lanes);
    random.fill_normal(noise, 1024);
    std::transform(noise.begin(), noise.end(), x.begin(), [](double normal) { return 0.01 * normal; });
  }

  double noise_deg() const { return std::max(observation_.noise_deg, least_noise_deg); }

  /// The sensor's noise that the annealing begins with: three times what the chains leave unexplained.
  double first_noise_deg(Group& group) const {
    const auto size = static_cast<std::size_t>(density_.blocks()) * lanes;
    std::vector<double> sway(size), residual(size);
    Density::Workspace work(density_);
    density_.model(observation_, group.sampler.coordinates(), sway, residual, work);
    const double unexplained_deg = root_mean_square(residual) / sim::rad_per_deg;
    return std::clamp(3.0 * unexplained_deg, 2.0 * noise_deg(), std::max(highest_noise_deg, 2.0 * noise_deg()));
  }

  void adapt(Sampler& sampler, int moves, int leaps) {
    for (int move = 0; move < moves && !stopped_; ++move) {
      sampler.move(leaps);
      sampler.adapt(target_acceptance);
    }
    sampler.end_adapting();
  }

  void warm_up(Group& group, int number, std::span<const State> starts) {
    Sampler& sampler = group.sampler;
    place(group, number, starts);
    const auto size = static_cast<std::size_t>(density_.size());
    std::vector<double> information(triangle(size));
    double noise = first_noise_deg(group), step = 0.2;
    const double stages = std::max(1.0, decid::log(noise / noise_deg()) / decid::log(lowering) + 1.0);
    for (int stage = 0; !stopped_; ++stage) {
      sampler.fix_noise(noise);
      std::fill(information.begin(), information.end(), 0.0);
      sampler.add_information(information);
      sampler.set_metric(information);
      sampler.begin_adapting(step);
      adapt(sampler, settings_.annealing_moves, annealing_leaps);
      step = std::clamp(sampler.middle_step(), 0.02, 0.4);
      if (number == 0) report("annealing", 0.5 * warming_share * std::min(1.0, (stage + 1) / stages));
      if (noise <= noise_deg()) break;
      noise = std::max(noise_deg(), noise / lowering);
    }
    sampler.fix_noise({});
    std::fill(information.begin(), information.end(), 0.0);
    sampler.add_information(information);
    sampler.set_metric(information);
    for (int window = 0; window < windows && !stopped_; ++window) {
      sampler.begin_adapting(step);
      std::fill(information.begin(), information.end(), 0.0);
      Sampler::Lanes log_noise{};
      for (int part = 0; part < window_information; ++part) {
        for (int move = 0; move < settings_.window_moves / window_information && !stopped_; ++move) {
          sampler.move(window_leaps);
          sampler.adapt(target_acceptance);
          if (part == 0) continue;
          for (int chain = 0; chain < lanes; ++chain)
            log_noise[static_cast<std::size_t>(chain)] +=
                decid::log(density_.state(sampler.coordinates(), chain).sensor_noise_deg);
        }
        sampler.add_information(information);
      }
      sampler.end_adapting();
      step = sampler.middle_step();
      for (double& value : information) value /= window_information;
      sampler.set_metric(information);
      const int counted = settings_.window_moves / window_information * (window_information - 1);
      for (double& sum : log_noise) sum /= counted;
      restart_stuck(group, number * windows + window, log_noise);
      if (number == 0) report("warming up", warming_share * (0.5 + 0.5 * (window + 1) / windows));
    }
    sampler.begin_adapting(step);
    adapt(sampler, settling_moves, settings_.leaps);
  }

  /// A chain that takes more of the recording for the sensor's noise than others do is in a place that explains less of
  /// it: it goes on from where one of those is that explain most. The mean of the logarithm of the noise over a window
  /// is known to 0.01, and 0.04 more stand for a likelihood that is e^-48 of theirs at 1210 blocks.
  void restart_stuck(Group& group, int round, const Sampler::Lanes& log_noise) {
    const double least = *std::ranges::min_element(log_noise);
    std::vector<std::size_t> good;
    for (std::size_t l = 0; l < lanes; ++l)
      if (log_noise[l] <= least + stuck_log_noise) good.push_back(l);
    const Random random(settings_.seed, Stream::posterior, restarting + static_cast<std::uint64_t>(round));
    const std::span<double> x = group.sampler.coordinates();
    for (std::size_t l = 0; l < lanes; ++l) {
      if (log_noise[l] <= least + stuck_log_noise) continue;
      const std::size_t from = good[random.below(l, good.size())];
      for (std::size_t i = 0; i < x.size(); i += lanes) x[i + l] = x[i + from];
      ++group.restarts;
    }
  }

  void draw(Group& group, int count) {
    Sampler& sampler = group.sampler;
    for (int i = 0; i < count && !stopped_; ++i) {
      sampler.move(settings_.leaps);
      for (int chain = 0; chain < lanes; ++chain) {
        const auto l = static_cast<std::size_t>(chain);
        group.states[l].push_back(density_.state(sampler.coordinates(), chain));
        group.energy[l].push_back(sampler.energy()[l]);
        group.acceptance += sampler.acceptance()[l];
        group.divergences += sampler.diverged()[l] ? 1 : 0;
      }
    }
  }

  /// The first `draws` of each chain.
  void judge(int draws) {
    Posterior& r = result_;
    r.chains_ = settings_.groups * lanes;
    r.states_.clear();
    r.divergences_ = 0;
    r.restarts_ = 0;
    r.leaps_ = 0;
    r.acceptance_ = 0.0;
    ChainDraws energy;
    for (const Group& group : groups_) {
      for (const std::vector<State>& chain : group.states)
        r.states_.insert(r.states_.end(), chain.begin(), chain.begin() + draws);
      for (const std::vector<double>& chain : group.energy) energy.emplace_back(chain.begin(), chain.begin() + draws);
      r.divergences_ += group.divergences;
      r.restarts_ += group.restarts;
      r.leaps_ += group.sampler.leaps() * lanes;
      r.acceptance_ += group.acceptance / static_cast<double>(group.states.front().size() * lanes * groups_.size());
    }
    r.energy_fraction_ = energy_fraction(energy);
    r.rhat_.clear();
    r.effective_.clear();
    for (int quantity = 0; quantity < Density::globals; ++quantity) {
      ChainDraws chains;
      for (int chain = 0; chain < r.chains_; ++chain) {
        std::vector<double>& values = chains.emplace_back();
        for (int i = 0; i < draws; ++i)
          values.push_back(Posterior::value(r.states_[static_cast<std::size_t>(chain * draws + i)], quantity));
      }
      r.rhat_.push_back(rhat(chains));
      r.effective_.push_back(posterior::effective_draws(chains));
    }
  }

  bool enough() const {
    return std::ranges::all_of(result_.rhat_, [&](double value) { return value <= settings_.largest_rhat; }) &&
           std::ranges::all_of(result_.effective_, [&](double value) { return value >= settings_.effective_draws; });
  }

  void report(const char* stage, double done) {
    if (!progress_) return;
    const double worst = result_.rhat_.empty() ? 0.0 : *std::ranges::max_element(result_.rhat_);
    if (!progress_({stage, done, worst})) stopped_ = true;
  }

  // Numbers of random numbers besides those of the groups' samplers.
  static constexpr std::uint64_t starting = std::uint64_t{1} << 32, restarting = std::uint64_t{2} << 32;

  const Density& density_;
  const Observation& observation_;
  Settings settings_;
  const OnProgress& progress_;
  std::deque<Group> groups_;
  std::atomic<bool> stopped_{false};
  Posterior result_;
};

Posterior sample(const Density& density, const Observation& observation, const Settings& settings,
                 std::span<const State> starts, const OnProgress& progress) {
  Run run(density, observation, settings, progress);
  return run(starts);
}

}  // namespace decid::posterior
