// Frequency responses of an identification: see frequency_response.hpp.
#include "identify/frequency_response.hpp"

#include "base/error.hpp"

namespace decid {
namespace {

constexpr int fewest_cycles_to_skip_one = 3;

}  // namespace

void add_frequency_response(Identification& id) {
  try {
    const int cycles = id.protocol.cycles();
    const sim::FrequencyResponse analysis(id.protocol, cycles >= fewest_cycles_to_skip_one ? 1 : 0);
    FrequencyResponses found;
    found.cycles = analysis.cycles();
    if (id.tilt) {
      const std::vector<float> measured(id.tilt->tilt_rad.begin(), id.tilt->tilt_rad.end());
      found.recorded = analysis.measure(id.sway_rad, measured);
    } else {
      found.recorded = analysis.measure(id.sway_rad, id.tilt_rad);
    }
    if (id.fitted_rad.size() == id.sway_rad.size()) found.model = analysis.measure(id.fitted_rad, id.tilt_rad);
    found.linear = analysis.linear(id.parameters, id.protocol.body);
    id.frf = std::move(found);
  } catch (const Error& error) {
    id.warnings.push_back("no frequency response: " + error.problem());
  }
}

}  // namespace decid
