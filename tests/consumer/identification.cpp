// Identifies a recording with the built-in model, as the README does: here one that is simulated with known parameters.
#include <cmath>
#include <cstdio>
#include <decid/identify/identify.hpp>
#include <decid/sim/streams.hpp>
#include <vector>

namespace {

std::vector<double> recording(const decid::Model& model) {
  const decid::sim::Simulator simulator(model.protocol);
  std::vector<double> sway_rad(static_cast<std::size_t>(simulator.samples()));
  simulator.run(model.parameters().middle(), decid::Random(7, decid::sim::streams::vestibular_noise, 0), sway_rad);
  return sway_rad;
}

}  // namespace

int main() {
  const decid::Model model = decid::built_in_model();
  const std::vector<double> sway_rad = recording(model);

  const decid::RecordingResult result = decid::identify(model, sway_rad, 100.0);  // samples in rad, rate in Hz
  const decid::Estimate& estimate = result.estimate;
  for (std::size_t p = 0; p < estimate.parameters.size(); ++p)
    std::printf("%-8s %g\n", model.parameters()[p].name.c_str(), estimate.parameters[p]);

  // The mean of squared errors, as parts of the ranges: guessing would err by about a twelfth.
  double squares = 0.0;
  for (std::size_t p = 0; p < estimate.parameters.size(); ++p) {
    const decid::sim::ParameterInfo& info = model.parameters()[p];
    squares += std::pow((estimate.parameters[p] - info.middle()) / info.range(), 2) / 7.0;
  }
  const decid::Explanation& explanation = result.explanation;
  std::printf("mean squared error %.4f of the ranges; follows the tilt %.2f\n", squares, explanation.response_ratio);
  return squares < 1.0 / 12 && explanation.response_ratio > 0.3 && explanation.ood_score < 1.0 ? 0 : 1;
}
