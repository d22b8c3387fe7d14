// Unrecorded signals: see inferred.hpp.
#include "posterior/density/inferred.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/math/statistics.hpp"
#include "base/text.hpp"

namespace decid::posterior {
namespace {

/// Returns the places of the blocks that are not missing.
std::vector<int> recorded_blocks_of(const Observation& observation) {
  std::vector<int> recorded;
  for (int block = 0; block < static_cast<int>(observation.sway.size()); ++block)
    if (!std::ranges::binary_search(observation.missing.blocks, block)) recorded.push_back(block);
  return recorded;
}

/// Appends the values of these blocks as append() does.
void append_blocks(std::span<const double> side_by_side, std::span<const int> blocks, int chains,
                   std::vector<double>& draws) {
  for (std::size_t chain = 0; chain < static_cast<std::size_t>(chains); ++chain)
    for (const int block : blocks) draws.push_back(side_by_side[static_cast<std::size_t>(block) * lanes + chain]);
}

/// Appends values of each chain, stored lane by lane, as values of one draw after the other.
void append(std::span<const double> side_by_side, int chains, std::vector<double>& draws) {
  for (std::size_t chain = 0; chain < static_cast<std::size_t>(chains); ++chain)
    for (std::size_t i = chain; i < side_by_side.size(); i += lanes) draws.push_back(side_by_side[i]);
}

}  // namespace

Band make_band(std::span<const double> values, int times) {
  const auto count = static_cast<std::size_t>(std::max(times, 0));
  if (count == 0 || values.empty() || values.size() % count != 0)
    throw Error(Code::size_mismatch, "band of draws", format("%zu values at %d times", values.size(), times),
                "give the same number of values per time");
  Band band;
  std::vector<double> here(values.size() / count);
  for (std::size_t time = 0; time < count; ++time) {
    for (std::size_t draw = 0; draw < here.size(); ++draw) here[draw] = values[draw * count + time];
    std::ranges::sort(here);
    band.low.push_back(quantile_of_sorted(here, 0.05));
    band.middle.push_back(quantile_of_sorted(here, 0.5));
    band.high.push_back(quantile_of_sorted(here, 0.95));
  }
  return band;
}

Inferred infer(const Density& density, const Observation& observation, const Posterior& found,
               bool keeps_log_likelihood) {
  const auto size = static_cast<std::size_t>(density.size()) * lanes;
  const auto blocks = static_cast<std::size_t>(density.blocks()), edges = static_cast<std::size_t>(density.edges());
  std::vector<double> x(size), sway(blocks * lanes), residual(blocks * lanes), noise(edges * lanes), tilt(noise.size());
  std::vector<double> left_out(blocks * lanes), all_sway, all_noise, all_tilt, likelihood;
  const std::vector<int> recorded = recorded_blocks_of(observation);
  Density::Workspace work(density);
  for (int first = 0; first < found.points(); first += lanes) {
    const int here = std::min(lanes, found.points() - first);
    for (int chain = 0; chain < lanes; ++chain) {  // unused lanes repeat the last point
      const std::span<const double> point = found.point(first + std::min(chain, here - 1));
      if (point.size() * lanes != size)
        throw Error(Code::size_mismatch, "posterior", format("has points of %zu coordinates", point.size()),
                    format("give one of this density, which has %d", density.size()));
      for (std::size_t i = 0; i < point.size(); ++i) x[i * lanes + static_cast<std::size_t>(chain)] = point[i];
    }
    density.model(observation, x, sway, residual, work);
    density.perceive(x, noise, tilt, work);
    append(sway, here, all_sway);
    append(noise, here, all_noise);
    append(tilt, here, all_tilt);
    density.leave_block_out(observation, x, left_out, work);
    append_blocks(left_out, recorded, here, likelihood);
  }
  Inferred inferred{make_band(all_sway, density.blocks()),
                    make_band(all_noise, density.edges()),
                    make_band(all_tilt, density.edges()),
                    leave_one_out(likelihood, static_cast<int>(recorded.size())),
                    recorded,
                    {}};
  if (keeps_log_likelihood) inferred.log_likelihood = std::move(likelihood);
  return inferred;
}

}  // namespace decid::posterior
