// The controller's perception of the platform in each chain: its vestibular noise, and the integral of the passed
// velocity.
#include <array>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/text.hpp"
#include "posterior/sampling/detail/chains.hpp"

namespace decid::posterior {

void Density::perceive(std::span<const double> x, std::span<double> noise_rad_s, std::span<double> tilt_rad,
                       Workspace& work) const {
  const auto all = static_cast<std::size_t>(size()) * lanes, results = static_cast<std::size_t>(edges()) * lanes;
  if (x.size() != all || noise_rad_s.size() != results || tilt_rad.size() != results)
    throw Error(Code::size_mismatch, "posterior",
                format("got %zu coordinates and space for %zu results", x.size(), noise_rad_s.size()),
                format("give %zu and twice %zu", all, results));
  const Chains c = chains(x, {});
  noise_.synthesize(x.data(), work.velocity.data(), work.noise_work.data(), isa_);
  kernels(isa_).refine(bins_ + 1, work.velocity.data(), work.fine.data());
  kernels(isa_).dead_band(halves(), dead_band_values(c, work));
  std::array<double, lanes> tilt{};
  const auto lead = static_cast<std::size_t>(lead_steps_ / bin_steps_);
  for (std::size_t edge = 0; edge < static_cast<std::size_t>(edges()); ++edge) {
    const std::size_t bin = lead + edge;
    // Removes the damping of the transforms.
    const double begin_s = first_step_ * sim::integration_step_s + static_cast<double>(bin) * bin_s();
    const double undamp_s = bin_s() * decid::exp(damping_ * begin_s);
    for (std::size_t l = 0; l < lanes; ++l) {
      const std::size_t at = edge * lanes + l;
      noise_rad_s[at] = c.noise_gain[l] * work.velocity[bin * lanes + l];
      tilt_rad[at] = tilt[l];
      tilt[l] += c[sim::Coefficient::tilt][l] * undamp_s * 0.5 *
                 (work.halves[2 * bin * lanes + l] + work.halves[(2 * bin + 1) * lanes + l]);
    }
  }
}

}  // namespace decid::posterior
