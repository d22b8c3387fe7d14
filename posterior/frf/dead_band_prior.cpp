// Coordinates for Nv and theta: see dead_band_prior.hpp.
#include "posterior/frf/dead_band_prior.hpp"

#include <algorithm>

namespace decid::frf {
namespace {

constexpr std::size_t side = 512;   // cells; blocks, and cells in each
constexpr std::size_t nodes = 129;  // per side, where the passing gain is computed; it is linear between them

}  // namespace

DeadBandPrior::DeadBandPrior(const posterior::Quantile& nv, const posterior::Quantile& theta,
                             const std::function<double(double nv, double theta)>& passes)
    : min_theta_(theta.low), max_theta_(theta.low + theta.range) {
  const auto place_of = [](std::size_t node) { return static_cast<double>(node) / (nodes - 1); };
  std::vector<double> known;
  for (std::size_t i = 0; i < nodes; ++i)
    for (std::size_t j = 0; j < nodes; ++j)
      known.push_back(passes(nv.value_at(place_of(i)), theta.value_at(place_of(j))));
  const double node_theta = theta.range / (nodes - 1);
  for (std::size_t i = 0; i < side; ++i) {
    for (std::size_t j = 0; j < side; ++j) {
      const double of_nv = (static_cast<double>(i) + 0.5) / side, of_theta = (static_cast<double>(j) + 0.5) / side;
      const double at_i = of_nv * (nodes - 1), at_j = of_theta * (nodes - 1);
      const auto low_i = static_cast<std::size_t>(at_i), low_j = static_cast<std::size_t>(at_j);
      const double fraction_i = at_i - static_cast<double>(low_i), fraction_j = at_j - static_cast<double>(low_j);
      const double* corner = known.data() + low_i * nodes + low_j;
      const double left = corner[0] + fraction_i * (corner[nodes] - corner[0]);
      const double right = corner[1] + fraction_i * (corner[nodes + 1] - corner[1]);
      cells_.push_back({nv.value_at(of_nv), theta.value_at(of_theta), left + fraction_j * (right - left),
                        (right - left) / node_theta});
    }
  }
  const auto by_place = [](const Cell& a, const Cell& b) { return a.nv < b.nv || (a.nv == b.nv && a.theta < b.theta); };
  std::sort(cells_.begin(), cells_.end(), [&](const Cell& a, const Cell& b) {
    return a.passing < b.passing || (a.passing == b.passing && by_place(a, b));
  });
  for (std::size_t block = 0; block < side; ++block) {
    const auto first = cells_.begin() + static_cast<std::ptrdiff_t>(block * side);
    const double before = block > 0 ? (first - 1)->passing : first->passing;
    edges_.push_back(0.5 * (before + first->passing));
  }
  edges_.push_back(cells_.back().passing);
  for (std::size_t block = 0; block < side; ++block) {
    const auto first = cells_.begin() + static_cast<std::ptrdiff_t>(block * side);
    std::sort(first, first + side, by_place);
  }
}

DeadBandPrior::Point DeadBandPrior::at(double passing_rank, double nv_rank) const {
  const auto below = [](double place) { return std::min(static_cast<std::size_t>(place), side - 1); };
  const double place = passing_rank * side;
  const std::size_t block = below(place);
  const double rise = edges_[block + 1] - edges_[block];
  const double passing = edges_[block] + (place - static_cast<double>(block)) * rise;
  const Cell& cell = cells_[block * side + below(nv_rank * side)];
  // Theta is adjusted, so that the passing gain depends only on its rank. Where that is impossible, hardly anything
  // depends on it.
  const double max_shift = (max_theta_ - min_theta_) / 64;
  const double shift = cell.by_theta < 0.0 ? (passing - cell.passing) / cell.by_theta : 0.0;
  const double theta = cell.theta + std::clamp(shift, -max_shift, max_shift);
  return {cell.nv, std::clamp(theta, min_theta_, max_theta_), rise * side};
}

}  // namespace decid::frf
