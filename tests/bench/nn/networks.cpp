// The networks that are timed are those that users run.
#include "bench/nn/networks.hpp"

#include <doctest/doctest.h>

#include "dataset/image/image.hpp"
#include "identify/model.hpp"
#include "identify/training/presets.hpp"
#include "sim/protocol.hpp"

using namespace decid;

namespace {

void check_same(const bench::NamedNetwork& timed, const std::string& preset_name) {
  const Preset& preset = preset_named(preset_name);
  const Model model(sim::default_protocol(), preset.image, preset.architecture);
  const nn::Network<float> network(timed.input, timed.architecture);
  CHECK(network.architecture() == model.network.architecture());
  CHECK(timed.input == model.network.input_shape());
}

}  // namespace

TEST_CASE("the network that benchmarks call Best is the default preset's, NetB the paper's") {
  check_same(bench::best_network, "best");
  check_same(bench::named_networks[1], "paper");
}
