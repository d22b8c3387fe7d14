// Following of a recording, with trials simulated for it alone.
#pragma once

#include <vector>

#include "identify/following.hpp"

namespace decid::test {

class FollowingAlone {
 public:
  explicit FollowingAlone(const sim::Simulator& simulator) : simulator_(simulator), following_(simulator.protocol()) {}

  double measure(const sim::Parameters& parameters, std::span<const float> sway_rad,
                 Following::Spread* spread = nullptr) const {
    Following::Simulated simulated;
    simulator_.run_all(
        Following::trials,
        [&](int i) {
          return sim::TrialInput{sim::single_pendulum().parameters.simulable(parameters),
                                 Random(0, Stream::vestibular_noise, static_cast<std::uint64_t>(i))};
        },
        [&](int i, const sim::Outcome& outcome, std::span<double> sway) {
          if (outcome.valid) simulated.put(i, sway);
        });
    return following_.measure(simulated, sway_rad, spread);
  }

 private:
  const sim::Simulator& simulator_;
  Following following_;
};

}  // namespace decid::test
