// Coordinates for Nv and theta that a frequency response can distinguish. A response shows how much passes the dead
// band, but hardly which of the two lets it pass: a thin, bent ridge that chains in Nv and theta cannot follow. One
// coordinate is the passing gain's rank in the prior. The other is Nv's rank among points of equal gain. Both are
// uniform under the prior if the priors of Nv and theta are. Normal priors need no such coordinates, which end with a
// grid: they would cut their tails.
#pragma once

#include <functional>
#include <vector>

#include "posterior/density/priors.hpp"

namespace decid::frf {

class DeadBandPrior {
 public:
  struct Point {
    double nv, theta;
    double by_rank;  ///< derivative of the passing gain by its rank
  };

  /// nv, theta: uniform priors. passes(nv, theta): returns the passing gain.
  DeadBandPrior(const posterior::Quantile& nv, const posterior::Quantile& theta,
                const std::function<double(double nv, double theta)>& passes);

  /// Returns the point at two ranks from 0 to 1: of the passing gain, and of Nv.
  Point at(double passing_rank, double nv_rank) const;

 private:
  struct Cell {
    double nv, theta;
    double passing, by_theta;  // the passing gain, and its derivative by theta
  };
  double min_theta_, max_theta_;
  std::vector<Cell> cells_;    // of a grid, in blocks by passing gain, in each by Nv
  std::vector<double> edges_;  // passing gains between the blocks
};

}  // namespace decid::frf
