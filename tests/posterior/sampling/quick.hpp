// Settings with which a short trial is sampled within a second.
#pragma once

#include "posterior/posterior.hpp"

namespace decid::test {

inline posterior::Settings quick() {
  return {.seed = 7,
          .groups = 1,
          .annealing_transitions = 5,
          .window_transitions = 9,
          .max_leapfrog_steps = 40,
          .block = 10,
          .rounds = 1,
          .trial_draws = 20,
          .min_draws = 20,
          .max_draws = 20};
}

}  // namespace decid::test
