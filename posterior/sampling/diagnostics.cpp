// Diagnostics of chains: see diagnostics.hpp.
#include "posterior/sampling/diagnostics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "base/math/statistics.hpp"

namespace decid::posterior {
namespace {

ChainDraws split(const ChainDraws& chains) {
  ChainDraws halves;
  for (const std::vector<double>& chain : chains) {
    const auto half = static_cast<std::ptrdiff_t>(chain.size() / 2);
    halves.emplace_back(chain.begin(), chain.begin() + half);
    halves.emplace_back(chain.end() - half, chain.end());
  }
  return halves;
}

/// Returns each value's normal score by its rank among all; equal values share the mean of their ranks.
ChainDraws normal_scores(const ChainDraws& chains) {
  std::vector<double> sorted;
  for (const std::vector<double>& chain : chains) sorted.insert(sorted.end(), chain.begin(), chain.end());
  std::sort(sorted.begin(), sorted.end());
  ChainDraws scores = chains;
  for (std::vector<double>& chain : scores) {
    for (double& value : chain) {
      const auto [first, last] = std::equal_range(sorted.begin(), sorted.end(), value);
      const double rank = 0.5 * static_cast<double>((first - sorted.begin()) + (last - sorted.begin()) + 1);
      value = inverse_normal((rank - 0.375) / (static_cast<double>(sorted.size()) + 0.25));
    }
  }
  return scores;
}

bool are_finite(const ChainDraws& chains) {
  return std::ranges::all_of(chains, [](const std::vector<double>& chain) {
    return std::ranges::all_of(chain, [](double value) { return std::isfinite(value); });
  });
}

struct Variances {
  double within, pooled;
};
Variances variances(const ChainDraws& chains) {
  std::vector<double> means;
  double within = 0.0;
  for (const std::vector<double>& chain : chains) {
    means.push_back(decid::mean(chain));
    within += sample_variance(chain) / static_cast<double>(chains.size());
  }
  const auto length = static_cast<double>(chains.front().size());
  return {within, within * (length - 1.0) / length + sample_variance(means)};
}

double plain_rhat(const ChainDraws& chains) {
  const Variances found = variances(chains);
  if (found.pooled == 0.0) return 1.0;
  if (found.within == 0.0) return std::numeric_limits<double>::infinity();
  return std::sqrt(found.pooled / found.within);
}

}  // namespace

double rhat(const ChainDraws& chains) {
  if (!are_finite(chains)) return std::numeric_limits<double>::infinity();
  const ChainDraws halves = split(chains);
  std::vector<double> all;
  for (const std::vector<double>& half : halves) all.insert(all.end(), half.begin(), half.end());
  const double middle = median(std::move(all));
  ChainDraws folded = halves;
  for (std::vector<double>& half : folded)
    for (double& value : half) value = std::abs(value - middle);
  return std::max(plain_rhat(normal_scores(halves)), plain_rhat(normal_scores(folded)));
}

namespace {

double effective_of(const ChainDraws& halves) {
  const std::size_t length = halves.front().size();
  const double draws = static_cast<double>(length * halves.size());
  const Variances found = variances(halves);
  if (!(found.pooled > 0.0)) return draws;
  const auto correlation = [&](std::size_t lag) {
    double covariance = 0.0;
    for (const std::vector<double>& half : halves) {
      const double mean = decid::mean(half);
      double sum = 0.0;
      for (std::size_t i = lag; i < length; ++i) sum += (half[i] - mean) * (half[i - lag] - mean);
      covariance += sum / static_cast<double>(length - 1) / static_cast<double>(halves.size());
    }
    return 1.0 - (found.within - covariance) / found.pooled;
  };
  double sum = -1.0, last = std::numeric_limits<double>::infinity();
  for (std::size_t lag = 0; lag + 1 < length; lag += 2) {
    const double pair = (lag == 0 ? 1.0 : correlation(lag)) + correlation(lag + 1);
    if (pair < 0.0) break;
    last = std::min(last, pair);
    sum += 2.0 * last;
  }
  return draws / std::max(sum, 1.0 / (decid::log(draws) / decid::log(10.0)));
}

/// Returns the effective draws of whether a draw is in a tail.
template <class IsInTail>
double effective_where(const ChainDraws& chains, const IsInTail& is_in_tail) {
  ChainDraws halves = split(chains);
  for (std::vector<double>& half : halves)
    for (double& value : half) value = is_in_tail(value) ? 1.0 : 0.0;
  return effective_of(halves);
}

}  // namespace

double effective_draws(const ChainDraws& chains) {
  return are_finite(chains) ? effective_of(normal_scores(split(chains))) : 0.0;
}

double mean_effective_draws(const ChainDraws& chains) {
  return are_finite(chains) ? effective_of(split(chains)) : 0.0;
}

double tail_effective_draws(const ChainDraws& chains) {
  if (!are_finite(chains)) return 0.0;
  std::vector<double> all;
  for (const std::vector<double>& chain : chains) all.insert(all.end(), chain.begin(), chain.end());
  const double low = quantile(all, 0.05), high = quantile(all, 0.95);
  // From its own side each, because many draws may be equal to the limit.
  return std::min(effective_where(chains, [&](double value) { return value <= low; }),
                  effective_where(chains, [&](double value) { return value >= high; }));
}

double energy_fraction(const ChainDraws& energy) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const std::vector<double>& chain : energy) {
    double sum = 0.0;
    for (std::size_t i = 1; i < chain.size(); ++i) sum += (chain[i] - chain[i - 1]) * (chain[i] - chain[i - 1]);
    const double variance = sample_variance(chain);
    if (!(variance > 0.0)) return std::numeric_limits<double>::quiet_NaN();
    smallest = std::min(smallest, sum / static_cast<double>(chain.size() - 1) / variance);
  }
  return smallest;
}

bool chains_agree(std::span<const double> rhat, std::span<const double> effective_draws) {
  return !rhat.empty() && std::ranges::all_of(rhat, [](double value) { return value <= agreed_rhat; }) &&
         std::ranges::all_of(effective_draws, [](double value) { return value >= 100.0; });
}

}  // namespace decid::posterior
