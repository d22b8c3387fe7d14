// Transitions where recordings say nothing: they lead from draws of the prior to draws of the prior.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "base/math/random.hpp"
#include "posterior/sampling/sampler.hpp"
#include "tests/helpers.hpp"

namespace decid::test {

/// Sets all chains to independent draws of the prior. `common`: globals that later trials have from the first one.
inline void set_to_prior(posterior::Sampler& sampler, std::span<const std::size_t> common, const Random& random,
                         std::uint64_t& drawn) {
  using posterior::lanes;
  for (std::size_t t = 0; t < sampler.target().trials(); ++t) {
    const posterior::Density& density = sampler.target().density(t);
    const std::span<double> x = sampler.coordinates(t);
    random.fill_normal(x, drawn);
    drawn += x.size();
    const auto noises = static_cast<std::size_t>(density.noise_size());
    for (const std::size_t global : common)
      for (std::size_t l = 0; l < lanes; ++l)
        x[(noises + global) * lanes + l] = sampler.coordinates(0)[(noises + global) * lanes + l];
    for (int chain = 0; chain < lanes; ++chain) {
      const double nv = density.state(x, chain).parameters[sim::Nv];
      for (std::size_t i = 0; i < noises; ++i)
        x[i * lanes + static_cast<std::size_t>(chain)] *= std::sqrt(nv * nv + 0.05 * 0.05);
    }
  }
}

/// Checks that transitions keep the distribution of the prior: after two of them, from independent draws, a trial's
/// coordinates from `first` on, `count` of them, are standard normal. So no chain has to mix, which takes thousands of
/// transitions where small Nv confines all noise. each(): called after every second transition. Returns how many
/// independent draws were checked.
template <class Each>
int check_prior_is_kept(posterior::Sampler& sampler, std::span<const std::size_t> common, std::size_t trial,
                        std::size_t first, std::size_t count, const Each& each) {
  using posterior::lanes;
  const Random random(7, sim::streams::sensor_noise, 0);
  std::uint64_t drawn = 1;
  constexpr int starts = 500;
  std::vector<double> sum(count), squares(count), moved(count);
  for (int i = 0; i < starts; ++i) {
    set_to_prior(sampler, common, random, drawn);
    const std::vector<double> before(sampler.coordinates(trial).begin(), sampler.coordinates(trial).end());
    sampler.begin_adapting(0.05);
    sampler.move(20);
    sampler.move(20);
    const std::span<const double> x = sampler.coordinates(trial);
    for (std::size_t q = 0; q < count; ++q) {
      for (std::size_t l = 0; l < lanes; ++l) {
        const double value = x[(first + q) * lanes + l], change = value - before[(first + q) * lanes + l];
        sum[q] += value;
        squares[q] += value * value;
        moved[q] += change * change;
      }
    }
    each();
  }
  // 5 standard errors, of means 0.016 and of variances 0.022.
  constexpr int draws = starts * lanes;
  for (std::size_t q = 0; q < count; ++q) {
    CAPTURE(q);
    CHECK(within(sum[q] / draws, 0.0, 0.08));
    CHECK(within(squares[q] / draws, 1.0, 0.11));
    CHECK(moved[q] / draws > 0.05);  // 2 where draws were independent; least for Nv, which the noise confines
  }
  return draws;
}

}  // namespace decid::test
