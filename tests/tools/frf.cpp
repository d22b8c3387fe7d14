// How often the warning that sway hardly follows the tilt is given to trials that do follow it: README quotes it.
#include "tools/frf.hpp"

#include <doctest/doctest.h>

#include <algorithm>

#include "dataset/dataset.hpp"

namespace decid::tools {

TEST_CASE("frequency response: of fresh trials of the default protocol a quarter is said to hardly follow the tilt") {
  constexpr int trials = 200;
  dataset::DatasetRequest request;
  request.protocol = sim::default_protocol();
  request.count = trials;
  request.seed = 4242;
  const dataset::Dataset data = dataset::generate(request);
  const sim::Stimulus stimulus = sim::make_stimulus(data.protocol);
  Identification id;
  id.protocol = data.protocol;
  id.parameters = sim::middle_parameters();
  for (int k = 0; k < data.samples; ++k)
    id.tilt_rad.push_back(static_cast<float>(stimulus.tilt_at(k * data.protocol.steps_per_sample())));
  int warned = 0;
  for (int i = 0; i < trials; ++i) {
    const auto sway = data.trial(i);
    id.sway_rad.assign(sway.begin(), sway.end());
    id.warnings.clear();
    add_frequency_response(id);
    warned += std::ranges::any_of(id.warnings,
                                  [](const std::string& w) { return w.find("hardly follows") != std::string::npos; });
  }
  // 26% of 500; the deviation of a share of 200 is 3%.
  CHECK(warned <= 0.35 * trials);
  CHECK(warned >= 0.17 * trials);
}

}  // namespace decid::tools
