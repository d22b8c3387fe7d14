// Chains of a sampler where recordings say nothing: their draws are the prior's.
#pragma once

#include <span>
#include <vector>

#include "posterior/sampling/sampler.hpp"
#include "tests/helpers.hpp"

namespace decid::test {

/// Settles the chains, draws, and checks that the coordinates of a trial from `first` on, `count` of them, are standard
/// normal. each(): called after every draw. Returns the number of draws, of all chains.
template <class Each>
int check_draws_of_prior(posterior::Sampler& sampler, std::size_t trial, std::size_t first, std::size_t count,
                         const Each& each) {
  using posterior::lanes;
  sampler.begin_adapting(0.3);
  // Small steps, or small Nv, where all noise is in a narrow neck, is left out.
  for (int i = 0; i < 200; ++i) {
    sampler.move(48);
    sampler.adapt(0.95);
  }
  sampler.end_adapting();
  constexpr int draws = 2000;
  std::vector<double> sum(count), squares(count);
  for (int i = 0; i < draws; ++i) {
    sampler.move(48);
    const std::span<const double> x = sampler.coordinates(trial);
    for (std::size_t q = 0; q < count; ++q) {
      for (std::size_t l = 0; l < lanes; ++l) {
        const double value = x[(first + q) * lanes + l];
        sum[q] += value;
        squares[q] += value * value;
      }
    }
    each();
  }
  // 16,000 draws, worth at least a twentieth of that: 5 standard errors of means (0.035) and of variances (0.05).
  for (std::size_t q = 0; q < count; ++q) {
    CHECK(within(sum[q] / (draws * lanes), 0.0, 0.18));
    CHECK(within(squares[q] / (draws * lanes), 1.0, 0.25));
  }
  return draws * lanes;
}

}  // namespace decid::test
