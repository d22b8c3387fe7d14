// Presets: each makes a network for its image of any protocol, and folded images take the protocol's own cycles.
#include "identify/training/presets.hpp"

#include <cmath>
#include <set>

#include "base/error.hpp"
#include "identify/network/model.hpp"
#include "sim/fft.hpp"
#include "tests/helpers.hpp"

namespace decid::tools {
namespace {

/// A sum of sines: cycles of any length.
sim::Protocol sines(double cycle_s, int cycles, double rate_hz = 100.0, double lead_in_s = 0.0) {
  sim::Protocol protocol;
  protocol.name = "sines";
  protocol.experiment.sample_rate_hz = rate_hz;
  protocol.experiment.stimulus = sim::Sines{
      .components = {{1.0 / cycle_s, 0.5, 0.0}}, .cycle_s = cycle_s, .cycles = cycles, .lead_in_s = lead_in_s};
  protocol.validate();
  return protocol;
}

/// Two cycles of 61.226 s at 100 Hz: 6122.6 samples each.
sim::Protocol uneven() {
  sim::Protocol protocol = sim::default_protocol();
  protocol.sequence().state_s = 0.253;
  protocol.sequence().lead_out_s = 0.008;  // the trial's length is one
  protocol.validate();
  return protocol;
}

double highest_hz(const dataset::ImageSettings& image, double rate_hz) {
  return rate_hz * image.rows / image.window;
}

const char* const folding[] = {"best", "short", "firmware"};

}  // namespace

TEST_CASE("presets: each makes a network of seven outputs for its image, whatever the protocol") {
  const std::vector<sim::Protocol> protocols{sim::default_protocol(), sim::short_protocol(), sines(10.0, 3),
                                             sines(40.0, 1, 50.0), sines(3.0, 20, 200.0, 1.5)};
  for (const Preset& preset : presets()) {
    CAPTURE(preset.name);
    CHECK_FALSE(preset.description.empty());
    for (const sim::Protocol& protocol : protocols) {
      CAPTURE(protocol.name);
      CAPTURE(protocol.samples());
      const Head& head = head_named(preset.head, preset.name);
      Model model(protocol, image_for(preset, protocol), preset.architecture, head);
      const dataset::ImageShape image = model.images().shape();
      CHECK(model.network.input_shape().size() == image.size());
      CHECK(model.network.output_shape().size() ==
            static_cast<int>(head.outputs(sim::single_pendulum().parameters.size())));
    }
  }
}

TEST_CASE("presets: with another head the last layer has its outputs, the others stay") {
  for (const decid::Preset& preset : decid::presets()) {
    const decid::Preset other = with_head(preset, "mixture 3", 7, "--head");
    CHECK(other.head == "mixture 3");
    const auto layers = preset.architecture.substr(0, preset.architecture.rfind("fc "));
    CHECK(other.architecture == layers + "fc 108");
    CHECK(with_head(other, preset.head, 7, "--head").architecture == preset.architecture);
  }
  test::check_error([] { with_head(decid::presets()[0], "mixtures", 7, "--head"); }, Code::file_unsupported);
}

TEST_CASE("presets: time series are of cycles up to eight, in blocks of 0.1 s up to 2048 of them") {
  const Preset& series = preset_named("series");
  CHECK(image_for(series, sim::default_protocol()) == series.image);
  const auto check = [&](const sim::Protocol& protocol, int fold, int block, int rows, int first_sample = 0) {
    CAPTURE(protocol.duration_s());
    const dataset::ImageSettings image = image_for(series, protocol);
    CHECK(image.fold == fold);
    CHECK(image.block == block);
    CHECK(image.first_sample == first_sample);
    CHECK(dataset::ImageMaker(image, protocol.experiment).shape().rows == rows);
  };
  check(sim::short_protocol(), 3, 10, 200, 197);
  check(sines(3.0, 8, 200.0, 1.5), 8, 20, 30, 300);
  check(sines(3.0, 9), 1, 10, 270);
  check(sines(500.0, 1), 1, 25, 2000);
  check(sines(302.5, 9), 1, 133, 2046);
  check(uneven(), 1, 10, 1224);
  check(sines(40.0, 1, 10.0), 1, 1, 400);
}

TEST_CASE("presets: the image of its own protocol is the one that is written down; without folds that of every one") {
  CHECK(image_for(preset_named("best"), sim::default_protocol()) == preset_named("best").image);
  CHECK(image_for(preset_named("firmware"), sim::default_protocol()) == preset_named("best").image);
  CHECK(image_for(preset_named("short"), sim::short_protocol()) == preset_named("short").image);
  for (const std::string name : {"paper", "small"})
    for (const sim::Protocol& protocol : {sim::default_protocol(), sim::short_protocol(), sines(10.0, 3, 50.0)})
      CHECK(image_for(preset_named(name), protocol) == preset_named(name).image);
}

TEST_CASE("presets: a folded image's window is a cycle, its rows reach the same frequency") {
  struct Case {
    double cycle_s;
    int cycles;
    double rate_hz, lead_in_s;
  };
  for (const std::string name : folding)
    for (const Case& c :
         {Case{30.0, 4, 100.0, 0.0}, {30.0, 1, 100.0, 2.0}, {25.0, 3, 200.0, 1.5}, {60.0, 2, 50.0, 0.0}}) {
      const sim::Protocol protocol = sines(c.cycle_s, c.cycles, c.rate_hz, c.lead_in_s);
      CAPTURE(name);
      CAPTURE(c.cycle_s);
      const Preset& preset = preset_named(name);
      const dataset::ImageSettings image = image_for(preset, protocol);
      CHECK(image.window == std::lround(c.cycle_s * c.rate_hz));
      CHECK(image.fold == c.cycles);
      CHECK(image.first_sample == std::lround(c.lead_in_s * c.rate_hz));
      // To half a row.
      CHECK(std::abs(highest_hz(image, c.rate_hz) - highest_hz(preset.image, 100.0)) <= 0.5 / c.cycle_s + 1e-9);
      CHECK(image.channels == preset.image.channels);
      CHECK(image.half_spectrum);
      CHECK(image.standardize_rows);
      CHECK(dataset::ImageMaker(image, protocol.samples()).shape().columns == 1);
    }
}

TEST_CASE("presets: rows stay between 64 and 1024, and within the window's half") {
  const Preset& best = preset_named("best");
  CHECK(image_for(best, sines(2.0, 40)).rows == 64);     // 4.2 Hz would be 8
  CHECK(image_for(best, sines(500.0, 1)).rows == 1024);  // and here 2116
  CHECK(image_for(best, sines(1.0, 80)).rows == 51);     // of 100 samples
}

TEST_CASE("presets: cycles that cannot be folded are one window, as many as fit") {
  const Preset& best = preset_named("best");
  const auto check = [&](const sim::Protocol& protocol, int window, int columns = 1) {
    CAPTURE(protocol.samples());
    const dataset::ImageSettings image = image_for(best, protocol);
    CHECK(image.fold == 1);
    CHECK(image.window == window);
    CHECK(sim::max_prime_factor(image.window) <= sim::max_fft_prime);
    const dataset::ImageMaker maker(image, protocol.samples());
    CHECK(maker.shape().columns == columns);
    CHECK(maker.shape().rows == image.rows);
  };
  // No whole number of samples: both are 12245.2.
  check(uneven(), 12'245);
  CHECK(image_for(best, uneven()).rows == 518);  // 4.2 Hz
  // Too many.
  check(sines(0.2, 1001), 20'020);
  CHECK(image_for(best, sines(0.2, 1000)).fold == 1000);
  // Too long: 1311 s at 100 Hz are more than 131072; what is left is a second window.
  check(sines(1311.0, 2), dataset::max_window, 2);
  CHECK(image_for(best, sines(1310.0, 2)).fold == 2);
  // A prime beyond those that are transformed, 10007; twice that is none better, but one less is, 3 x 7 x 953.
  check(sines(100.07, 2, 100.0, 0.01), 20'013);
  CHECK(image_for(best, sines(100.07, 2, 100.0, 0.01)).first_sample == 1);
}

TEST_CASE("presets: names are unique, and one that is not there is answered with those that are") {
  std::set<std::string> names;
  for (const Preset& preset : presets()) {
    CHECK(names.insert(preset.name).second);
    CHECK(&preset_named(preset.name) == &preset);
  }
  for (const std::string& name : names) test::check_error([&] { preset_named("worst"); }, Code::setting_unknown, name);
  test::check_error([&] { preset_named("Best"); }, Code::setting_unknown, "'Best'");
}

}  // namespace decid::tools
