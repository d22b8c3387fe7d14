// The page of `decid stimulus --plot`: the tilt, its velocity and its amplitude spectrum, in one HTML file that opens
// offline.
#pragma once

#include <string>

#include "identify/result.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::tools {

/// The page of a valid protocol. `version` is decid's; `call` made the page. Deterministic; the protocol's name is
/// escaped. Long signals are thinned to the extremes of equal spans, so that a page stays below a few MB.
std::string stimulus_html(const sim::Protocol& protocol, const std::string& version, const Call& call);

/// One cycle's amplitude spectrum in degrees, mean removed: element k is at k / length Hz, k = 1 .. half the samples.
/// A cycle whose number of samples has a prime factor above 100 is shortened by a few samples, to keep its transform
/// fast.
struct AmplitudeSpectrum {
  double resolution_hz;
  std::vector<double> amplitude_deg;  ///< element 0, the mean, is 0
};
AmplitudeSpectrum amplitude_spectrum(const sim::Protocol& protocol);

}  // namespace decid::tools
