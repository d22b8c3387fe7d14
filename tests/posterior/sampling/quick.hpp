// Settings with which a short trial is sampled within a second.
#pragma once

#include "posterior/posterior.hpp"

namespace decid::test {

inline posterior::Settings quick() {
  return {.seed = 7,
          .groups = 1,
          .annealing_moves = 5,
          .window_moves = 9,
          .most_leaps = 40,
          .block = 10,
          .rounds = 1,
          .trial_draws = 20,
          .least_draws = 20,
          .most_draws = 20};
}

}  // namespace decid::test
