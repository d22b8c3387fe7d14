// Draws of the white noise given all other unknowns: see Density::draw_white_noise.
#include <algorithm>
#include <array>
#include <cmath>

#include "base/math/math.hpp"
#include "posterior/density/density.hpp"
#include "posterior/sampling/detail/chains.hpp"

namespace decid::posterior {

// Proposals are as wide as is best for one normal quantity, 2.4 times its standard deviation, if every row has white
// noise alone. The width does not depend on the coordinate, nor on any other: otherwise the acceptance would have to
// count the way back.
void Density::draw_white_noise(const Observation& observation, std::span<double> x, std::span<const double> normals,
                               std::span<const double> uniforms, Workspace& work) const {
  check(observation, x, std::min(normals.size(), uniforms.size()), white_noise_draws * lanes);
  const auto coordinate = [&](int quantity, std::size_t l) -> double& {
    return x[(static_cast<std::size_t>(noise_.size()) + place(quantity)) * lanes + l];
  };
  Chains c = chains(x, {});
  std::array<double, lanes> potential = forward(observation, x, c, work), proposal;
  const double by_coordinate = 2.0 * decid::log(priors_.sensor_noise_factor);  // of the logarithm of a row's variance
  const double width = 2.4 / std::sqrt(1.0 + 0.5 * spectrum_.rows() * by_coordinate * by_coordinate);
  for (std::size_t l = 0; l < lanes; ++l) {
    const double here = coordinate(sensor_noise, l);
    potential[l] += 0.5 * here * here;
  }
  for (std::size_t draw = 0; draw < white_noise_draws; ++draw) {
    for (std::size_t l = 0; l < lanes; ++l) {
      proposal[l] = std::fma(width, normals[draw * lanes + l], coordinate(sensor_noise, l));
      set_noise(c, l, proposal[l], coordinate(slow_noise, l), coordinate(slow_memory, l), {});
    }
    std::array<double, lanes> proposed = spectrum_.misfit(c.levels, work.unfolded, work.noise, isa_);
    spectrum_.leave_out(observation.missing, work.noise, proposed, isa_);
    for (std::size_t l = 0; l < lanes; ++l) {
      proposed[l] += 0.5 * proposal[l] * proposal[l];
      if (!(uniforms[draw * lanes + l] < decid::exp(std::min(0.0, potential[l] - proposed[l])))) continue;
      coordinate(sensor_noise, l) = proposal[l];
      potential[l] = proposed[l];
    }
  }
}

}  // namespace decid::posterior
