// Recordings as text: all dialects of CSV, OpenSim's .mot and .trc, brought to a protocol.
#include "recording/recording.hpp"

#include "recording/trial.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace decid;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile input("recording.csv");
  static const sim::Protocol protocol = sim::short_protocol();
  const std::filesystem::path& path = input.write(fuzz::to_text(data, size));
  // Its length picks the options, so that a seed is a file as people have it.
  recording::RecordingOptions options;
  if (size % 2 == 1) options.column = "2";
  if (size % 3 == 1) options.rate_hz = 50.0;
  if (size % 5 == 1) options.fill_gaps_s = 1.0;
  if (size % 7 == 1) options.tilt_column = "3";
  if (size % 11 == 1) options.skip_lines = 2;
  if (size % 13 == 1) options.section = "2";
  fuzz::accepts([&] {
    recording::RecordingOptions first_trial = options;
    first_trial.trial_column = "trial";
    const std::vector<std::string> trials = recording::list_trials(path, first_trial);
    REQUIRE_THAT(!trials.empty());
    first_trial.trial = trials.front();
    recording::read_recording(path, first_trial);
  });
  fuzz::accepts([&] {
    recording::Recording recording = recording::read_recording(path, options);
    REQUIRE_THAT(recording.signals.samples() >= 2);
    recording::bring_to_protocol(recording, protocol);
  });
  return 0;
}
