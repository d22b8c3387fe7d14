// Protocols as JSON, by the strict reader and by the one for what people write. One that is accepted can be written and
// read back, and simulated.
#include "sim/protocol/protocol_json.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace decid;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr int short_enough = 1000;
  const std::string text(fuzz::to_text(data, size));
  const auto tilt = [](const sim::TiltFileReference& file, double) {
    return std::vector<double>(file.is_cycle ? 20 : 30, 0.5);
  };
  for (const sim::ProtocolText& source : {sim::ProtocolText{"protocol"}, {"protocol", "file", tilt}}) {
    fuzz::accepts([&] {
      const sim::Protocol protocol = sim::protocol_from_text(text, source);
      const std::string written = sim::to_json(protocol);
      const sim::Protocol again = sim::protocol_from_json(written, "written");
      REQUIRE_THAT(sim::to_json(again) == written);
      if (protocol.samples() > short_enough) return;
      const sim::Simulator simulator(protocol);
      std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
      simulator.run(protocol.ranges().middle(), Random(1, sim::streams::vestibular_noise, 0), sway);
    });
  }
  return 0;
}
