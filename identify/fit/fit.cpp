// The fit: see fit.hpp.
#include "identify/fit/fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.hpp"
#include "base/math.hpp"
#include "identify/fit/cmaes.hpp"

namespace decid::fit {
namespace {

constexpr int dimensions = static_cast<int>(sim::parameter_count);
using Vector = Eigen::Matrix<double, dimensions, 1>;
using Matrix = Eigen::Matrix<double, dimensions, dimensions>;

// Tuned on trials of seeds that no figure is quoted for.
constexpr int population = 16;
constexpr int realisations = 16;
constexpr int rounds = 4;
constexpr int round_points = 96;
constexpr int round_realisations = 16;
constexpr double wider = 1.5;        // a round's variance beside that of the points it is drawn after
constexpr double settled = 0.002;    // a search whose longest axis is below this part of the ranges has ended
constexpr double least_weight = 12;  // effective samples below which the weights of a round are tempered
constexpr long long rounds_simulations = 1LL * rounds * round_points * round_realisations;
constexpr long long generation_simulations = 1LL * population * realisations;
constexpr double counted_twice = 2.5;  // errors beside the deviations of draws where a prior has read the recording too
constexpr std::uint64_t rounds_item = 1'000'000;  // random numbers of the rounds, apart from those of the searches

constexpr double widest = 0.28867513459481287;  // deviation of a uniform distribution over the range: 1 / sqrt(12)

struct Point {
  Vector unit;
  double cost;
};

Vector vector_of(std::span<const double> values) {
  return Eigen::Map<const Vector>(values.data());
}

/// Mean and covariance of weighted points.
struct Moments {
  Vector mean = Vector::Zero();
  Matrix covariance = Matrix::Zero();
};
Moments moments(std::span<const Point> points, std::span<const double> weights) {
  Moments m;
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    m.mean += weights[i] * points[i].unit;
    sum += weights[i];
  }
  m.mean /= sum;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector d = points[i].unit - m.mean;
    m.covariance += weights[i] / sum * d * d.transpose();
  }
  return m;
}

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

/// A Gaussian cut to the unit box, to draw from and to weigh what was drawn.
class Proposal {
 public:
  explicit Proposal(const Moments& m) : mean_(m.mean) {
    // No direction narrower than a thousandth of the ranges: the points it came from may lie in a plane.
    const Matrix covariance = wider * m.covariance + 1e-6 * Matrix::Identity();
    factor_ = covariance.llt().matrixL();
  }
  /// Minus the logarithm of its density, up to a constant.
  double energy(const Vector& unit) const {
    return 0.5 * factor_.triangularView<Eigen::Lower>().solve(unit - mean_).squaredNorm();
  }
  /// Draws until one is in the box; as the mean is, at worst one in some hundred is.
  Vector draw(const Random& random, std::uint64_t& next) const {
    constexpr int tries = 20'000;
    Vector unit = mean_;
    for (int i = 0; i < tries; ++i) {
      Vector normal;
      for (int d = 0; d < dimensions; ++d) normal[d] = random.normal(next++);
      unit = mean_ + factor_ * normal;
      if (unit.minCoeff() >= 0 && unit.maxCoeff() <= 1) break;
    }
    return unit.cwiseMax(0).cwiseMin(1);
  }

 private:
  Vector mean_;
  Matrix factor_;
};

class Fit {
 public:
  Fit(const Likelihood& likelihood, const Settings& settings) : likelihood_(likelihood), settings_(settings) {}

  /// CMA-ES from all starts side by side, so that their trials fill the simulator's lanes together.
  void search(std::span<const Start> starts) {
    std::vector<CmaEs> searches;
    for (const Start& start : starts) {
      std::vector<double> unit = to_unit(start.parameters);
      for (double& u : unit) u = std::clamp(u, 0.0, 1.0);
      if (start.prior > 0) priors_.emplace_back(vector_of(unit), start.prior);
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
          points.push_back(vector_of(std::span(asked).subspan(static_cast<std::size_t>(i * dimensions), dimensions)));
      }
      const std::vector<double> costs = evaluate(points, realisations, 0);
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
    const Random random(settings_.seed, Stream::fit_search, rounds_item);
    std::uint64_t next = 0;
    Moments about = around_optimum();
    double effective = 0;
    for (int round = 0; round < rounds; ++round) {
      const Proposal proposal(about);
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
      const std::vector<double> weights = tempered_weights(excess, least_weight, effective);
      about = moments(drawn, weights);
    }
    result.effective_samples = effective;
    result.parameters = from_unit(std::span(about.mean.data(), dimensions));
    for (std::size_t p = 0; p < sim::parameter_count; ++p) {
      const auto d = static_cast<Eigen::Index>(p);
      const double range = sim::parameter_info[p].high - sim::parameter_info[p].low;
      const double deviation = std::sqrt(about.covariance(d, d));
      result.standard_error[p] = range * (priors_.empty() ? deviation : std::min(counted_twice * deviation, widest));
    }
  }

  Result result;

 private:
  std::vector<double> evaluate(std::span<const Vector> points, int each, std::uint64_t first) {
    std::vector<sim::Parameters> candidates;
    for (const Vector& point : points) candidates.push_back(from_unit(std::span(point.data(), dimensions)));
    const std::vector<Cost> costs = likelihood_.costs(candidates, each, settings_.seed, first);
    result.simulations += static_cast<long long>(candidates.size()) * each;
    std::vector<double> values;
    for (std::size_t i = 0; i < costs.size(); ++i) {
      values.push_back(costs[i].value + prior_energy(points[i]));
      const bool stands = costs[i].sensor_noise_deg > 0;
      if (each == realisations && stands && (!result.stands || costs[i].value < result.cost)) {
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
    for (const auto& [centre, deviation] : priors_)
      energy += 0.5 * (unit - centre).squaredNorm() / (deviation * deviation);
    return energy;
  }

  /// The points that the searches met with costs nearest to the best one's.
  Moments around_optimum() {
    std::ranges::stable_sort(met_, {}, &Point::cost);
    std::vector<double> costs;
    for (const Point& point : met_) costs.push_back(point.cost);
    // Twice the temperature of the likelihood: wide enough to be drawn from.
    for (double& cost : costs) cost *= 0.5;
    double effective = 0;
    return moments(met_, tempered_weights(costs, 4 * dimensions, effective));
  }

  const Likelihood& likelihood_;
  Settings settings_;
  std::vector<Point> met_;
  std::vector<std::pair<Vector, double>> priors_;  // centre and deviation
  double found_ = std::numeric_limits<double>::infinity();
};

}  // namespace

std::vector<double> to_unit(const sim::Parameters& parameters) {
  std::vector<double> unit;
  for (std::size_t p = 0; p < sim::parameter_count; ++p) {
    const auto& [low, high] = std::pair(sim::parameter_info[p].low, sim::parameter_info[p].high);
    unit.push_back((parameters[p] - low) / (high - low));
  }
  return unit;
}

sim::Parameters from_unit(std::span<const double> unit) {
  sim::Parameters parameters{};
  for (std::size_t p = 0; p < sim::parameter_count; ++p)
    parameters[p] = sim::parameter_info[p].low + unit[p] * (sim::parameter_info[p].high - sim::parameter_info[p].low);
  return parameters;
}

Start middle_start() {
  return {sim::middle_parameters(), 0.3};
}

Start random_start(std::uint64_t seed, std::uint64_t number) {
  const Random random(seed, Stream::fit_search, 2 * rounds_item + number);
  std::vector<double> unit;
  for (std::uint64_t p = 0; p < sim::parameter_count; ++p) unit.push_back(random.uniform(p));
  return {from_unit(unit), 0.3};
}

long long least_simulations(std::size_t starts) {
  return static_cast<long long>(starts) * generation_simulations + rounds_simulations;
}

void check_budget(const Settings& settings, std::size_t starts) {
  if (settings.simulations < least_simulations(starts))
    throw Error(
        "fit", "a budget of " + std::to_string(settings.simulations) + " simulations",
        "allow " + std::to_string(least_simulations(starts)) + " or more for " + std::to_string(starts) + " starts");
}

Result fit(const sim::Simulator& simulator, std::span<const float> sway_rad, std::span<const Start> starts,
           const Settings& settings) {
  if (starts.empty()) throw Error("fit", "no start", "give one or more");
  check_budget(settings, starts.size());
  const Likelihood likelihood(simulator, sway_rad);
  Fit fit(likelihood, settings);
  fit.search(starts);
  fit.spread();
  return fit.result;
}

}  // namespace decid::fit
