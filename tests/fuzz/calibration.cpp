// Calibrations that decid calibrate --resume goes on from.
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tools/decid/results/calibrated_trials.hpp"

using namespace decid;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile input("calibration.json");
  static const sim::ParameterTable ranges = sim::default_protocol().ranges();
  const std::filesystem::path& path = input.write(fuzz::to_text(data, size));
  // Whatever settings the file has are the call's: a mutation of them would hide the trials.
  Json settings, network;
  fuzz::accepts([&] {
    const Json json = parse_json(read_file(path), "calibration");
    if (!json.is_object() || !json.contains("settings") || !json["settings"].contains("protocol")) return;
    settings = json["settings"];
    network = json.value("network", Json(nullptr));
    const std::string protocol = print_json(settings["protocol"]);
    settings["protocol"] = parse_json(sim::to_json(sim::protocol_from_json(protocol, "calibration")), "calibration");
  });
  fuzz::accepts([&] {
    for (const CalibratedTrial& trial : tools::earlier_trials(path, settings, network, ranges.size()))
      REQUIRE_THAT(trial.truth.size() == ranges.size() && trial.below.size() == ranges.size());
  });
  return 0;
}
