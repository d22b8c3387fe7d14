// A person who leans slowly: see slow_lean.hpp.
#include "recording/quality/detail/slow_lean.hpp"

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "base/math/math.hpp"
#include "recording/quality/detail/block_means.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {
namespace {

constexpr double most_deg = 0.6, largest_tilt_deg = 2.0, shortest_cycle_s = 40.0, block_s = 0.1;

bool is_checked(const sim::Protocol& protocol) {
  const auto* sequence = std::get_if<sim::Sequence>(&protocol.experiment.stimulus);
  const sim::VestibularNoise usual, &noise = protocol.noise.vestibular;
  return sequence != nullptr && sequence->cycles >= 2 && sequence->amplitude_deg <= largest_tilt_deg &&
         protocol.experiment.cycle_s() >= shortest_cycle_s && noise.scale_deg <= usual.scale_deg &&
         noise.exponent == usual.exponent && noise.low_hz >= usual.low_hz * (1.0 - 1e-9);
}

}  // namespace

void look_for_slow_lean(std::span<const double> sway_rad, const sim::Protocol& protocol, Warnings& warnings) {
  if (!is_checked(protocol)) return;
  const double rate_hz = protocol.experiment.sample_rate_hz;
  const auto begin = static_cast<std::size_t>(std::round(protocol.experiment.lead_in_s() * rate_hz));
  const auto length = static_cast<std::size_t>(std::round(protocol.experiment.cycle_s() * rate_hz));
  if (begin + 2 * length > sway_rad.size()) return;
  std::vector<double> difference(length);
  for (std::size_t k = 0; k < length; ++k) difference[k] = sway_rad[begin + length + k] - sway_rad[begin + k];
  difference = block_means(difference, static_cast<std::size_t>(std::max(1.0, std::round(block_s * rate_hz))));
  const auto n = static_cast<long long>(difference.size());
  double power = 0.0;
  for (const long long harmonic : {1LL, 2LL}) {
    double sine = 0.0, cosine = 0.0;
    for (long long k = 0; k < n; ++k) {
      const SinCos at = sincos_of_turn(harmonic * k, n);
      sine += at.sin * difference[static_cast<std::size_t>(k)];
      cosine += at.cos * difference[static_cast<std::size_t>(k)];
    }
    power += 2.0 * (sine * sine + cosine * cosine) / (static_cast<double>(n) * static_cast<double>(n));
  }
  const double rms_deg = std::sqrt(0.5 * power) / sim::rad_per_deg;
  if (rms_deg < most_deg) return;
  add_caution(warnings, "slow_lean",
              "the two cycles of the sway differ slowly by " + three_digits(rms_deg) +
                  " degrees rms, more than in any body of the training: the person leaned to and fro within a minute, "
                  "or the sensor wandered; Kp and Kp_pass may then be too small by several standard deviations; look "
                  "at the sway, and repeat the trial with the person in one position");
}

}  // namespace decid::recording
