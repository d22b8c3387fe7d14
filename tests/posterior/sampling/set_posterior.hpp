// Sets what a posterior found, through its archive.
#pragma once

#include <tuple>
#include <vector>

#include "posterior/posterior.hpp"

namespace decid::test {

struct PosteriorSetter {
  const std::vector<posterior::State>& states;
  const std::vector<double>&rhat, &effective_draws;
  int divergences;

  template <class... Fields>
  void operator()(Fields&... fields) {
    const auto all = std::tie(fields...);
    std::get<1>(all) = divergences;  // after the number of chains
    std::get<std::vector<posterior::State>&>(all) = states;
    std::get<sizeof...(Fields) - 2>(all) = rhat;
    std::get<sizeof...(Fields) - 1>(all) = effective_draws;
  }
};

inline void set_posterior(posterior::Posterior& found, const std::vector<posterior::State>& states,
                          const std::vector<double>& rhat, const std::vector<double>& effective_draws,
                          int divergences = 0) {
  PosteriorSetter set{states, rhat, effective_draws, divergences};
  found.archive(set);
}

}  // namespace decid::test
