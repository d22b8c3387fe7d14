// The least misfit of a smc.hpp density within its ranges: Levenberg and Marquardt's method with bounds, from several
// starts (Nocedal, Wright, Numerical Optimization, 2nd ed. 2006, ch. 10 and 16).
#pragma once

#include "posterior/frf/smc.hpp"

namespace decid::frf {

struct OptimumSettings {
  std::uint64_t seed = 1;
  int starts = 24;  ///< draws from the prior
  int max_steps = 300;
};

struct Optimum {
  std::vector<double> x;
  double misfit = 0.0;
  int agreeing = 0;  ///< starts that end within a millionth of the least misfit
};

/// Minimises the misfit plus half the squares of the coordinates after the first `uniform`, which stay between 0 and 1.
/// The result depends only on the settings. Throws Error for less than one start or step, and if the misfit is infinite
/// at all of 1000 draws from the prior.
Optimum minimise(std::size_t size, std::size_t uniform, const Evaluate& evaluate, const OptimumSettings& settings);

}  // namespace decid::frf
