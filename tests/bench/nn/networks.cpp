// The networks that are timed are those that users run.
#include "bench/nn/networks.hpp"

#include <doctest/doctest.h>

#include "dataset/image/image.hpp"
#include "identify/network/head.hpp"
#include "identify/network/model.hpp"
#include "identify/training/presets.hpp"
#include "sim/protocol/protocol.hpp"

using namespace decid;

namespace {

void check_same(const bench::NamedNetwork& timed, const std::string& preset_name) {
  const Preset& preset = preset_named(preset_name);
  const Model model(sim::default_protocol(), preset.image, preset.architecture, head_named(preset.head, "preset"));
  const nn::Network<float> network(timed.input, timed.architecture);
  CHECK(network.architecture() == model.network.architecture());
  CHECK(timed.input == model.network.input_shape());
}

}  // namespace

TEST_CASE("the networks that benchmarks call Best, NetB and Series are those of the presets") {
  check_same(bench::best_network, "best");
  check_same(bench::series_network, "series");
  check_same(bench::named_networks[1], "paper");
}
