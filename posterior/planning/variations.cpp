// Variations of a protocol: see variations.hpp.
#include "posterior/planning/variations.hpp"

#include <cmath>
#include <variant>

#include "base/error.hpp"
#include "base/text.hpp"

namespace decid::posterior {

sim::Protocol with_peak_to_peak(sim::Protocol protocol, double degrees) {
  if (!(degrees > 0.0 && std::isfinite(degrees)))
    throw Error(Code::setting_out_of_range, "amplitude", format("is %g", degrees), "give degrees above 0");
  const double before = sim::make_stimulus(protocol.experiment).peak_to_peak_rad() / sim::rad_per_deg;
  if (!(before > 0.0))
    throw Error(Code::setting_conflict, "amplitude", "the platform of protocol '" + protocol.name + "' does not move",
                "give a protocol with a stimulus");
  const double factor = degrees / before;
  struct Scale {
    double factor;
    void operator()(sim::Sequence& kind) const { kind.amplitude_deg *= factor; }
    void operator()(sim::MeasuredTilt& kind) const {
      for (double& tilt : kind.tilt_deg) tilt *= factor;
    }
    void operator()(sim::Sines& kind) const {
      for (sim::Sine& sine : kind.components) sine.amplitude_deg *= factor;
    }
    void operator()(sim::RaisedCosines& kind) const {
      for (sim::Move& move : kind.moves) move.amplitude_deg *= factor;
    }
  };
  std::visit(Scale{factor}, protocol.experiment.stimulus);
  protocol.validate();
  return protocol;
}

sim::Protocol with_cycles(sim::Protocol protocol, int cycles) {
  std::visit([&](auto& kind) { kind.cycles = cycles; }, protocol.experiment.stimulus);
  protocol.noise.vestibular.period_s = 0.0;  // another length has another default
  protocol.validate();
  return protocol;
}

}  // namespace decid::posterior
