// The fit: see fit.hpp.
#include "tools/compare/fit.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "tools/compare/cmaes.hpp"
#include "tools/compare/proposal.hpp"

namespace decid::iterative {
namespace {

// Tuned on trials of seeds that no figure is quoted for.
constexpr int population = 16;
constexpr int realisations_each = 16;
constexpr int rounds = 4;
constexpr int round_points = 96;
constexpr int round_realisations = 16;
constexpr double wider = 1.5;      // ratio of a round's variance to the variance of the points before
constexpr double settled = 0.002;  // a search whose longest axis is below this part of the ranges has ended
constexpr double min_weight = 12;  // effective samples below which the weights of a round are tempered
constexpr long long rounds_simulations = 1LL * rounds * round_points * round_realisations;
constexpr long long generation_simulations = 1LL * population * realisations_each;
constexpr double counted_twice = 2.5;  // ratio of errors to standard deviations if the prior used the recording too
constexpr std::uint64_t rounds_item = 1'000'000;  // random numbers of the rounds, apart from those of the searches

constexpr double widest = 0.28867513459481287;  // sd of a uniform distribution over the range: 1 / sqrt(12)

/// exp(-(value - least) / temperature), the temperature being 1 or, if a few values would have all the weight, that at
/// which the effective number of samples (sum w)^2 / sum w^2 is `enough`.
std::vector<double> tempered_weights(std::span<const double> values, double enough, double& effective) {
  const double least = *std::ranges::min_element(values);
  std::vector<double> weights(values.size());
  const auto weigh = [&](double temperature) {
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      weights[i] = exp(-std::min((values[i] - least) / temperature, 700.0));
      sum += weights[i];
      squares += weights[i] * weights[i];
    }
    return sum * sum / squares;
  };
  effective = weigh(1);
  if (effective >= enough) return weights;
  double low = 0, high = 40;  // powers of 2
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (weigh(exp(0.6931471805599453 * middle)) < enough ? low : high) = middle;
  }
  weigh(exp(0.6931471805599453 * high));
  return weights;
}

class Fit {
 public:
  Fit(const sim::ParameterTable& table, const Likelihood& likelihood, const Settings& settings)
      : table_(table), likelihood_(likelihood), settings_(settings) {
    result.likeliest = sim::Parameters(table.size());
  }

  /// CMA-ES from all starts at once, so that their trials fill the simulator's lanes together.
  void search(std::span<const Start> starts) {
    const std::size_t dimensions = table_.size();
    std::vector<CmaEs> searches;
    for (const Start& start : starts) {
      std::vector<double> unit = table_.to_unit(start.parameters);
      for (double& u : unit) u = std::clamp(u, 0.0, 1.0);
      if (start.prior > 0) priors_.emplace_back(to_vector(unit), start.prior);
      searches.emplace_back(unit, start.spread, population, settings_.seed, searches.size());
    }
    std::vector<bool> ended(searches.size(), false);
    for (;;) {
      std::vector<std::size_t> running;
      for (std::size_t s = 0; s < searches.size(); ++s)
        if (!ended[s]) running.push_back(s);
      const auto wanted = static_cast<long long>(running.size()) * generation_simulations;
      if (running.empty() || result.simulations + wanted + rounds_simulations > settings_.simulations) break;
      std::vector<Vector> points;
      for (const std::size_t s : running) {
        const std::vector<double>& asked = searches[s].ask();
        for (int i = 0; i < population; ++i)
          points.push_back(to_vector(std::span(asked).subspan(static_cast<std::size_t>(i) * dimensions, dimensions)));
      }
      const std::vector<double> costs = evaluate(points, realisations_each, 0);
      for (std::size_t i = 0; i < running.size(); ++i) {
        const auto first = i * static_cast<std::size_t>(population);
        CmaEs& search = searches[running[i]];
        search.tell(std::span(costs).subspan(first, static_cast<std::size_t>(population)));
        for (std::size_t k = first; k < first + static_cast<std::size_t>(population); ++k) {
          met_.push_back({points[k], costs[k]});
          if (costs[k] < found_) {
            found_ = costs[k];
            result.start = static_cast<int>(running[i]);
          }
        }
        ended[running[i]] = search.longest_axis() < settled;
      }
    }
  }

  /// Rounds of weighted draws around the optimum, each after the round before.
  void spread() {
    const Random random(settings_.seed, search_stream, rounds_item);
    std::uint64_t next = 0;
    Moments about = around_optimum();
    double effective = 0;
    for (int round = 0; round < rounds; ++round) {
      const Proposal proposal(about, wider);
      std::vector<Vector> points(round_points);
      for (Vector& point : points) point = proposal.draw(random, next);
      // Realisations that no search has seen: it has adapted to its own.
      const std::vector<double> costs =
          evaluate(points, round_realisations, rounds_item + static_cast<std::uint64_t>(round * round_realisations));
      std::vector<Point> drawn;
      std::vector<double> excess;
      for (std::size_t i = 0; i < points.size(); ++i) {
        drawn.push_back({points[i], costs[i]});
        excess.push_back(costs[i] - proposal.energy(points[i]));
      }
      const std::vector<double> weights = tempered_weights(excess, min_weight, effective);
      about = moments(drawn, weights);
    }
    result.effective_samples = effective;
    result.parameters = table_.from_unit(std::span(about.mean.data(), table_.size()));
    result.standard_error = sim::Parameters(table_.size());
    for (std::size_t p = 0; p < table_.size(); ++p) {
      const auto d = static_cast<Eigen::Index>(p);
      const double range = table_[p].range();
      const double stddev = std::sqrt(about.covariance(d, d));
      result.standard_error[p] = range * (priors_.empty() ? stddev : std::min(counted_twice * stddev, widest));
    }
  }

  Result result;

 private:
  std::vector<double> evaluate(std::span<const Vector> points, int each, std::uint64_t first) {
    std::vector<sim::Parameters> candidates;
    for (const Vector& point : points) candidates.push_back(table_.from_unit(std::span(point.data(), table_.size())));
    const std::vector<Cost> costs = likelihood_.costs(candidates, each, settings_.seed, first);
    result.simulations += static_cast<long long>(candidates.size()) * each;
    std::vector<double> values;
    for (std::size_t i = 0; i < costs.size(); ++i) {
      values.push_back(costs[i].value + prior_energy(points[i]));
      const bool stands = costs[i].sensor_noise_deg > 0;
      if (each == realisations_each && stands && (!result.stands || costs[i].value < result.cost)) {
        result.stands = true;
        result.cost = costs[i].value;
        result.sensor_noise_deg = costs[i].sensor_noise_deg;
        result.likeliest = candidates[i];
      }
    }
    return values;
  }

  /// Minus the logarithm of the prior, up to a constant.
  double prior_energy(const Vector& unit) const {
    double energy = 0;
    for (const auto& [centre, stddev] : priors_) energy += 0.5 * (unit - centre).squaredNorm() / (stddev * stddev);
    return energy;
  }

  /// Returns the moments of the search points with costs nearest to the best cost.
  Moments around_optimum() {
    std::ranges::stable_sort(met_, {}, &Point::cost);
    std::vector<double> costs;
    for (const Point& point : met_) costs.push_back(point.cost);
    // Twice the temperature of the likelihood: wide enough to be drawn from.
    for (double& cost : costs) cost *= 0.5;
    double effective = 0;
    return moments(met_, tempered_weights(costs, 4.0 * static_cast<double>(table_.size()), effective));
  }

  const sim::ParameterTable& table_;
  const Likelihood& likelihood_;
  Settings settings_;
  std::vector<Point> met_;
  std::vector<std::pair<Vector, double>> priors_;  // centre and deviation
  double found_ = std::numeric_limits<double>::infinity();
};

}  // namespace

Start middle_start(const sim::ParameterTable& table) {
  return {table.middle(), 0.3};
}

Start random_start(const sim::ParameterTable& table, std::uint64_t seed, std::uint64_t number) {
  const Random random(seed, search_stream, 2 * rounds_item + number);
  std::vector<double> unit;
  for (std::uint64_t p = 0; p < table.size(); ++p) unit.push_back(random.uniform(p));
  return {table.from_unit(unit), 0.3};
}

long long min_simulations(std::size_t starts) {
  return static_cast<long long>(starts) * generation_simulations + rounds_simulations;
}

void check_budget(const Settings& settings, std::size_t starts) {
  if (settings.simulations < min_simulations(starts))
    throw Error(Code::setting_out_of_range, setting("simulations"), "is " + std::to_string(settings.simulations),
                "allow " + std::to_string(min_simulations(starts)) + " or more for " +
                    counted(static_cast<long long>(starts), "start"));
}

Result fit(const sim::Simulator& simulator, std::span<const float> sway_rad, std::span<const Start> starts,
           const Settings& settings) {
  if (starts.empty()) throw Error(Code::setting_out_of_range, "fit", "no start", "give one or more");
  check_budget(settings, starts.size());
  const sim::ParameterTable table = simulator.protocol().ranges();
  for (const Start& start : starts)
    if (start.parameters.size() != table.size())
      throw Error(Code::size_mismatch, "fit", "a start with " + std::to_string(start.parameters.size()) + " parameters",
                  "give all " + std::to_string(table.size()));
  const Likelihood likelihood(simulator, sway_rad);
  Fit fit(table, likelihood, settings);
  fit.search(starts);
  fit.spread();
  return fit.result;
}

}  // namespace decid::iterative
