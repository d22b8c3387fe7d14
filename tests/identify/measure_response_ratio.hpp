// ResponseRatio of a recording, with trials simulated for it alone.
#pragma once

#include <vector>

#include "identify/detail/as_recorded.hpp"
#include "identify/response_ratio.hpp"
#include "sim/streams.hpp"

namespace decid::test {

class ResponseRatioAlone {
 public:
  explicit ResponseRatioAlone(const sim::Simulator& simulator)
      : simulator_(simulator), response_ratio_(simulator.protocol()) {}

  /// Simulated trials have the recording's gaps too.
  double measure(const sim::Parameters& parameters, std::span<const float> sway_rad,
                 ResponseRatio::Spread* spread = nullptr, std::span<const SampleRange> gaps = {}) const {
    ResponseRatio::Simulated simulated;
    simulator_.run_all(
        ResponseRatio::trials,
        [&](int i) {
          return sim::TrialInput{sim::single_pendulum().parameters.simulable(parameters),
                                 Random(0, sim::streams::vestibular_noise, static_cast<std::uint64_t>(i))};
        },
        [&](int i, const sim::Outcome& outcome, std::span<double> sway) {
          bridge_gaps(sway, gaps);
          if (outcome.valid) simulated.put(i, sway);
        });
    return response_ratio_.measure(simulated, with_bridged_gaps({sway_rad.begin(), sway_rad.end()}, gaps), spread);
  }

 private:
  const sim::Simulator& simulator_;
  ResponseRatio response_ratio_;
};

}  // namespace decid::test
