// Models of other controllers that come with decid: they answer simulated recordings of laboratories as
// docs/guide/models.md says.
#include <doctest/doctest.h>

#include <cmath>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include "dataset/source.hpp"
#include "identify/evaluation/calibration_trials.hpp"
#include "identify/identify.hpp"
#include "sim/protocol/conditions.hpp"

using namespace decid;

namespace {

struct Figures {
  double mse = 0.0, coverage90 = 0.0;
};

/// Identifies `count` trials of 0.02 degrees with the model's recording artefacts.
Figures figures_of(const Model& model, int count) {
  sim::Protocol protocol = model.protocol;
  protocol.heights = {};
  protocol.noise.sensor = {0.02, 0.02};
  const sim::Simulator simulator(protocol.ideal());
  const sim::ParameterTable table = protocol.ranges();
  const sim::Parameters stddev = uniform_stddev(table);
  constexpr std::uint64_t seed = 4242;
  std::vector<recording::Trial> trials(static_cast<std::size_t>(count));
  std::vector<sim::Parameters> truth(trials.size());
  std::vector<std::uint64_t> numbers(trials.size());
  std::iota(numbers.begin(), numbers.end(), std::uint64_t{0});
  dataset::simulate_stream(simulator, seed, numbers,
                           [&](std::size_t place, const sim::TrialInput& trial, std::span<double> sway) {
                             sim::record(protocol, seed, numbers[place], sway);
                             truth[place] = trial.parameters;
                             trials[place] = recording::make_trial({sway.begin(), sway.end()});
                           });
  Figures found;
  Identifier identifier(model);
  const std::vector<Estimate> estimates = identifier.estimate(trials);
  const double each = 1.0 / static_cast<double>(trials.size() * table.size());
  for (std::size_t i = 0; i < trials.size(); ++i) {
    REQUIRE(estimates[i].distribution);
    for (std::size_t p = 0; p < table.size(); ++p) {
      const double error = (estimates[i].parameters[p] - truth[i][p]) / stddev[p];
      const double below = estimates[i].distribution->below(static_cast<int>(p), truth[i][p]);
      found.mse += error * error * each;
      found.coverage90 += below > 0.05 && below < 0.95 ? each : 0.0;
    }
  }
  return found;
}

}  // namespace

// The errors of 1,000 trials are 0.437 and 0.133 of the ranges' variance (docs/guide/models.md). One trial's has a
// standard deviation of 0.22 and 0.16, so the difference between the means of 300 and 1,000 trials has a standard error
// of 0.015 and 0.011. A trial's share of covered parameters has a standard deviation of 0.11 and 0.15, the mean of 300
// a standard error of 0.006 and 0.009. Each limit is at least four standard errors.
TEST_CASE("models of dec2015 and ic come with decid, and err and cover as documented") {
  for (const auto& [controller, mse, limit] : {std::tuple{"dec2015", 0.437, 0.06}, std::tuple{"ic", 0.133, 0.045}}) {
    const std::string name = controller;
    CAPTURE(name);
    const Model model = load_model(DECID_SOURCE_DIR "/models/" + std::string(controller) + ".safetensors");
    CHECK(std::string(model.protocol.experiment.body_model->name) == controller);
    const Figures found = figures_of(model, 300);
    CHECK(std::abs(found.mse - mse) < limit);
    CHECK(std::abs(found.coverage90 - 0.9) < 0.04);
  }
}
