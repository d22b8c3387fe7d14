// Nv and theta in coordinates that a frequency response tells apart. All that it shows of the two is how much passes
// the dead band, hardly any of it which of them lets it pass: a ridge, thin and bent, that chains in Nv and theta
// cannot walk along. Here one coordinate is what passes, by its rank in the prior, and the other Nv, by its rank among
// those with which as much passes; both are uniform beforehand as Nv and theta are.
#pragma once

#include <functional>
#include <vector>

#include "sim/parameters.hpp"

namespace decid::frf {

class DeadBandPrior {
 public:
  struct Point {
    double nv, theta;
    double by_rank;  ///< how fast what passes rises with its rank
  };

  /// passes(nv, theta): how much does; Nv and theta are uniform in their ranges in `table`.
  DeadBandPrior(const sim::ParameterTable& table, const std::function<double(double nv, double theta)>& passes);

  /// Ranks from 0 to 1: of what passes, and of Nv.
  Point at(double passing_rank, double nv_rank) const;

 private:
  struct Cell {
    double nv, theta;
    double passing, by_theta;  // what passes, and how fast it rises with theta
  };
  double min_theta_, max_theta_;
  std::vector<Cell> cells_;    // of a grid, in blocks by what passes, in each by Nv
  std::vector<double> edges_;  // what passes between the blocks
};

}  // namespace decid::frf
