// Sequential Monte Carlo whose proposals use the local information: see smc.hpp.
#include "posterior/frf/smc.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.hpp"
#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "base/parallel.hpp"
#include "base/setting.hpp"
#include "posterior/sampling/diagnostics.hpp"
#include "posterior/streams.hpp"

namespace decid::frf {
namespace {

constexpr int attempts = 1000;                   // to draw a possible point from the prior
constexpr double kept_fraction = 0.5;            // of the population's effective number, between powers
constexpr int bisections = 50;                   // of the next power
constexpr double shortest = 0.2, longest = 1.4;  // lengths of proposals, in standard deviations by the information
// Proposals with drift decorrelate faster; proposals without drift help where the information misleads.
constexpr double drifting = 0.75;    // fraction of the proposals
constexpr double of_uniform = 12.0;  // one over the variance of a uniform distribution between 0 and 1
constexpr std::size_t max_coordinates = 28;
constexpr std::uint64_t numbers_per_transition = 32;  // random numbers

void check(std::size_t size, const SmcSettings& settings) {
  const auto at_least = [](const std::string& setting, int value, int minimum) {
    require_at_least("particles, " + setting, value, minimum);
  };
  at_least("population", settings.population, settings.chains);
  at_least("stage_transitions", settings.stage_transitions, 1);
  at_least("settling_transitions", settings.settling_transitions, 0);
  at_least("chains", settings.chains, 1);
  at_least("thinning", settings.thinning, 1);
  at_least("min_draws", settings.min_draws, 4);
  at_least("max_draws", settings.max_draws, settings.min_draws);
  if (size < 1 || size > max_coordinates)
    throw Error(Code::setting_out_of_range, "particles", "got " + std::to_string(size) + " coordinates",
                "give 1 to 28");
}

/// A point, and the density's values there at a power of the likelihood.
struct Particle {
  std::vector<double> x;
  Local local;
  double potential = 0.0;        // minus the logarithm of the density
  std::vector<double> gradient;  // of the potential
  std::vector<double> factor;    // L of the information L L^t, prior included
  double log_determinant = 0.0;  // of L
};

void update_potential(Particle& particle, std::size_t uniform, double power) {
  const std::size_t size = particle.x.size();
  particle.potential = power * particle.local.misfit;
  particle.gradient.resize(size);
  particle.factor.resize(triangle(size));
  for (std::size_t i = 0; i < size; ++i) {
    const bool is_normal = i >= uniform;
    if (is_normal) particle.potential += 0.5 * particle.x[i] * particle.x[i];
    particle.gradient[i] = power * particle.local.gradient[i] + (is_normal ? particle.x[i] : 0.0);
    for (std::size_t j = 0; j <= i; ++j)
      particle.factor[triangle(i) + j] =
          power * particle.local.information[triangle(i) + j] + (i != j      ? 0.0
                                                                 : is_normal ? 1.0
                                                                             : of_uniform);
  }
  if (!factorize(size, particle.factor)) {  // no information: proposals of the prior's size
    std::fill(particle.factor.begin(), particle.factor.end(), 0.0);
    for (std::size_t i = 0; i < size; ++i) particle.factor[triangle(i) + i] = 1.0;
  }
  particle.log_determinant = 0.0;
  for (std::size_t i = 0; i < size; ++i) particle.log_determinant += decid::log(particle.factor[triangle(i) + i]);
}

struct Proposal {
  double length;
  double drift;  // length^2 / 2, or none
};

/// Returns the mean of proposals from a point.
std::vector<double> proposal_mean(const Particle& particle, const Proposal& proposal) {
  std::vector<double> x = particle.x;
  if (proposal.drift == 0.0) return x;
  std::vector<double> step = particle.gradient;
  solve_lower(x.size(), particle.factor, step);
  solve_upper(x.size(), particle.factor, step);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] -= proposal.drift * step[i];
  return x;
}

/// Returns the logarithm of the density of a proposal, without the terms that both directions share.
double log_density(const Particle& from, const std::vector<double>& to, const Proposal& proposal) {
  const std::vector<double> mean = proposal_mean(from, proposal);
  double squares = 0.0;
  for (std::size_t i = 0; i < to.size(); ++i) {  // of L^t (to - mean)
    double sum = 0.0;
    for (std::size_t k = i; k < to.size(); ++k) sum += from.factor[triangle(k) + i] * (to[k] - mean[k]);
    squares += sum * sum;
  }
  return from.log_determinant - 0.5 * squares / (proposal.length * proposal.length);
}

class Run {
 public:
  Run(std::size_t size, std::size_t uniform, const Evaluate& evaluate, const SmcSettings& settings)
      : size_(size),
        uniform_(uniform),
        evaluate_(evaluate),
        settings_(settings),
        population_(static_cast<std::size_t>(settings.population)) {}

  SmcResult operator()() {
    start();
    for (double power = 0.0; power < 1.0; ++result_.stages) {
      const double next = next_power(power);
      resample(next - power);
      power = next;
      apply_transitions(settings_.stage_transitions, power);
    }
    apply_transitions(settings_.settling_transitions, 1.0);
    draw();
    return std::move(result_);
  }

 private:
  /// Returns the random numbers of a particle; chains have numbers after the population's.
  Random random_numbers(std::size_t number) const { return {settings_.seed, posterior::streams::particles, number}; }

  void start() {
    parallel_for(settings_.population, [&](int i) {
      const auto number = static_cast<std::size_t>(i);
      const Random random = random_numbers(number);
      Particle& particle = population_[number];
      particle.x.resize(size_);
      particle.local.gradient.resize(size_);
      particle.local.information.resize(triangle(size_));
      for (int attempt = 0; attempt < attempts; ++attempt) {
        const std::uint64_t first = static_cast<std::uint64_t>(attempt) * numbers_per_transition;
        random.fill_normal(particle.x, first);
        for (std::size_t k = 0; k < uniform_; ++k) particle.x[k] = random.uniform(first + k);
        evaluate_(particle.x, particle.local);
        if (std::isfinite(particle.local.misfit)) return;
      }
      throw Error(Code::setting_out_of_range, "particles", "the likelihood is 0 at all draws from the prior",
                  "widen the prior");
    });
    transitions_ = attempts;
    result_.evaluations += settings_.population;
  }

  /// Returns the population's weights after a step of the power; the largest is 1.
  std::vector<double> weights(double step) const {
    double min_misfit = population_.front().local.misfit;
    for (const Particle& particle : population_) min_misfit = std::min(min_misfit, particle.local.misfit);
    std::vector<double> made;
    for (const Particle& particle : population_)
      made.push_back(decid::exp(-step * (particle.local.misfit - min_misfit)));
    return made;
  }

  double next_power(double power) const {
    const auto effective_fraction = [&](double step) {
      double sum = 0.0, squares = 0.0;
      for (const double weight : weights(step)) {
        sum += weight;
        squares += weight * weight;
      }
      return sum * sum / squares / static_cast<double>(population_.size());
    };
    if (effective_fraction(1.0 - power) >= kept_fraction) return 1.0;
    double low = 0.0, high = 1.0 - power;
    for (int i = 0; i < bisections; ++i) {
      const double middle = 0.5 * (low + high);
      (effective_fraction(middle) >= kept_fraction ? low : high) = middle;
    }
    return power + high;
  }

  /// Resamples systematically: particles stay in proportion to their weights.
  void resample(double step) {
    const std::vector<double> weight = weights(step);
    double total = 0.0;
    for (const double value : weight) total += value;
    const Random random = random_numbers(population_.size() + static_cast<std::size_t>(settings_.chains));
    const double offset = random.uniform(static_cast<std::uint64_t>(result_.stages));
    std::vector<Particle> chosen;
    double sum = 0.0;
    for (std::size_t i = 0; i < population_.size(); ++i) {
      sum += weight[i];
      const double expected = sum / total * static_cast<double>(population_.size());
      while (chosen.size() < population_.size() && offset + static_cast<double>(chosen.size()) < expected)
        chosen.push_back(population_[i]);
    }
    while (chosen.size() < population_.size()) chosen.push_back(population_.back());  // rounding may leave some out
    population_ = std::move(chosen);
  }

  void apply_transitions(int count, double power) {
    parallel_for(settings_.population, [&](int i) {
      Particle& particle = population_[static_cast<std::size_t>(i)];
      update_potential(particle, uniform_, power);
      for (int k = 0; k < count; ++k)
        transition(particle, random_numbers(static_cast<std::size_t>(i)), transitions_ + static_cast<std::uint64_t>(k),
                   power);
    });
    transitions_ += static_cast<std::uint64_t>(count);
    result_.evaluations += static_cast<long long>(count) * settings_.population;
  }

  /// Proposes another point, and moves the particle there if it is accepted.
  bool transition(Particle& particle, const Random& random, std::uint64_t number, double power) const {
    const std::uint64_t first = number * numbers_per_transition;
    const double length =
        shortest * decid::exp(decid::log(longest / shortest) * random.uniform(first + max_coordinates));
    const bool drifts = random.uniform(first + max_coordinates + 1) < drifting;
    const Proposal proposal{length, drifts ? 0.5 * length * length : 0.0};
    std::vector<double> step(size_);
    random.fill_normal(step, first);
    solve_upper(size_, particle.factor, step);
    Particle other;
    other.x = proposal_mean(particle, proposal);
    for (std::size_t i = 0; i < size_; ++i) other.x[i] += length * step[i];
    const auto is_inside = [](double value) { return value > 0.0 && value < 1.0; };
    if (!std::all_of(other.x.begin(), other.x.begin() + static_cast<std::ptrdiff_t>(uniform_), is_inside)) return false;
    other.local.gradient.resize(size_);
    other.local.information.resize(triangle(size_));
    evaluate_(other.x, other.local);
    if (!std::isfinite(other.local.misfit)) return false;
    update_potential(other, uniform_, power);
    const double change = other.potential - particle.potential + log_density(particle, other.x, proposal) -
                          log_density(other, particle.x, proposal);
    if (!std::isfinite(change)) return false;  // gradient or information is not finite there
    if (!(random.uniform(first + max_coordinates + 2) < decid::exp(-std::max(0.0, change)))) return false;
    particle = std::move(other);
    return true;
  }

  void draw() {
    const auto chains = static_cast<std::size_t>(settings_.chains);
    std::vector<Particle> particles;
    for (std::size_t c = 0; c < chains; ++c) particles.push_back(population_[c * population_.size() / chains]);
    result_.chains.resize(chains);
    std::vector<long long> accepted(chains, 0);
    int draws = 0;
    while (draws < settings_.max_draws) {
      const int more = std::min(std::max(settings_.min_draws, draws), settings_.max_draws - draws);
      parallel_for(settings_.chains, [&](int i) {
        const auto c = static_cast<std::size_t>(i);
        const Random random = random_numbers(population_.size() + c);
        auto number = static_cast<std::uint64_t>(draws) * static_cast<std::uint64_t>(settings_.thinning);
        for (int kept = 0; kept < more; ++kept) {
          for (int k = 0; k < settings_.thinning; ++k)
            accepted[c] += transition(particles[c], random, number++, 1.0) ? 1 : 0;
          result_.chains[c].insert(result_.chains[c].end(), particles[c].x.begin(), particles[c].x.end());
        }
      });
      draws += more;
      if (enough(draws)) break;
    }
    const long long transitions = static_cast<long long>(draws) * settings_.thinning * settings_.chains;
    long long sum = 0;
    for (const long long count : accepted) sum += count;
    result_.acceptance = static_cast<double>(sum) / static_cast<double>(transitions);
    result_.evaluations += transitions;
  }

  bool enough(int draws) {
    result_.rhat.clear();
    result_.effective.clear();
    for (std::size_t i = 0; i < size_; ++i) {
      posterior::ChainDraws values;
      for (const std::vector<double>& chain : result_.chains) {
        std::vector<double>& column = values.emplace_back();
        for (std::size_t k = 0; k < static_cast<std::size_t>(draws); ++k) column.push_back(chain[k * size_ + i]);
      }
      result_.rhat.push_back(posterior::rhat(values));
      result_.effective.push_back(posterior::effective_draws(values));
    }
    return std::ranges::all_of(result_.rhat, [&](double value) { return value <= settings_.max_rhat; }) &&
           std::ranges::all_of(result_.effective, [&](double value) { return value >= settings_.effective_draws; });
  }

  std::size_t size_, uniform_;
  const Evaluate& evaluate_;
  const SmcSettings& settings_;
  std::vector<Particle> population_;
  std::uint64_t transitions_ = 0;  // of each particle
  SmcResult result_;
};

}  // namespace

SmcResult sample_smc(std::size_t size, std::size_t uniform, const Evaluate& evaluate, const SmcSettings& settings) {
  check(size, settings);
  return Run(size, uniform, evaluate, settings)();
}

}  // namespace decid::frf
